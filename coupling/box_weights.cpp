#include "box_weights.hpp"

#include <stdexcept>

// one version of the loops for each generation of processors, chosen when the program starts
#define HOTBED_VECTORISED __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))

namespace hotbed
{
namespace
{

/// visit(cell, weight) for every cell that a particle reaches
template <class Visit> inline void forEachCell(const BoxWeights& weights, const BoxWeights::Particle& p, Visit&& visit)
{
    const double* x = weights.row.data() + p.row;
    const double* y = x + p.count[0];
    const double* z = y + p.count[1];
    for (int k = 0; k < p.count[2]; ++k)
        for (int j = 0; j < p.count[1]; ++j)
        {
            const double yz = y[j] * z[k];
            const int* cell = weights.cellOf + p.slot + j * weights.nx + k * weights.nxy;
            for (int i = 0; i < p.count[0]; ++i)
                if (cell[i] >= 0) visit(cell[i], x[i] * yz);
        }
}

/// the values of a particle or a cell, as one register where the processor has such
using Values1 = double;
using Values2 = double __attribute__((vector_size(16), aligned(8), may_alias));
using Values4 = double __attribute__((vector_size(32), aligned(8), may_alias));
using Values8 = double __attribute__((vector_size(64), aligned(8), may_alias));

template <class Values> inline void interpolateFields(const BoxWeights& weights, const double* cells, double* result)
{
    for (const BoxWeights::Particle& p : weights.particle)
    {
        Values sum = {};
        forEachCell(weights, p, [&](int cell, double w) { sum += w * reinterpret_cast<const Values*>(cells)[cell]; });
        *reinterpret_cast<Values*>(result) = sum;
        result += sizeof(Values) / sizeof(double);
    }
}

template <class Values> inline void depositFields(const BoxWeights& weights, const double* particles, double* cells)
{
    for (const BoxWeights::Particle& p : weights.particle)
    {
        const Values value = *reinterpret_cast<const Values*>(particles);
        forEachCell(weights, p, [&](int cell, double w) { reinterpret_cast<Values*>(cells)[cell] += w * value; });
        particles += sizeof(Values) / sizeof(double);
    }
}

} // namespace

double BoxWeights::mass(const Particle& p) const
{
    double sum = 0.0;
    forEachCell(*this, p, [&](int, double w) { sum += w; });
    return sum;
}

HOTBED_VECTORISED void interpolate(int fields, const BoxWeights& weights, const double* cells, double* result)
{
    if (fields == 1) return interpolateFields<Values1>(weights, cells, result);
    if (fields == 2) return interpolateFields<Values2>(weights, cells, result);
    if (fields == 4) return interpolateFields<Values4>(weights, cells, result);
    if (fields == 8) return interpolateFields<Values8>(weights, cells, result);
    throw std::invalid_argument("interpolate: 1, 2, 4 or 8 fields at a time");
}

HOTBED_VECTORISED void deposit(int fields, const BoxWeights& weights, const double* particles, double* cells)
{
    if (fields == 1) return depositFields<Values1>(weights, particles, cells);
    if (fields == 2) return depositFields<Values2>(weights, particles, cells);
    if (fields == 4) return depositFields<Values4>(weights, particles, cells);
    if (fields == 8) return depositFields<Values8>(weights, particles, cells);
    throw std::invalid_argument("deposit: 1, 2, 4 or 8 fields at a time");
}

} // namespace hotbed
