#include "cells.hpp"

#include "deen_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hotbed
{
namespace
{

bool empty(const Box& box)
{
    return box.low[0] > box.high[0];
}

/// ascending coordinates without the repetitions that round-off makes
std::vector<double> distinct(std::vector<double> values, double tolerance)
{
    std::sort(values.begin(), values.end());
    std::vector<double> out;
    for (double v : values)
        if (out.empty() || v - out.back() > tolerance) out.push_back(v);
    return out;
}

int nearest(const std::vector<double>& face, double x)
{
    const auto above = std::lower_bound(face.begin(), face.end(), x);
    if (above == face.begin()) return 0;
    if (above == face.end() || x - *(above - 1) < *above - x) return int(above - face.begin()) - 1;
    return int(above - face.begin());
}

} // namespace

BoxCells::BoxCells(const std::vector<Box>& boxes, const Box& domain) : nCells_(int(boxes.size())), domain_(domain)
{
    if (boxes.empty()) return;
    for (int a = 0; a < 3; ++a)
    {
        std::vector<double> all;
        double smallest = std::numeric_limits<double>::max();
        for (const Box& b : boxes)
        {
            all.push_back(b.low[a]);
            all.push_back(b.high[a]);
            smallest = std::min(smallest, b.high[a] - b.low[a]);
        }
        Axis& axis = axis_[a];
        axis.face = distinct(std::move(all), 1e-6 * smallest);
        nSlots_[a] = int(axis.face.size()) - 1;
        axis.origin = axis.face.front();
        const double spacing = (axis.face.back() - axis.face.front()) / nSlots_[a];
        axis.inverseSpacing = 1.0 / spacing;
        axis.uniform = true;
        for (int i = 0; i <= nSlots_[a]; ++i)
            axis.uniform = axis.uniform && std::abs(axis.face[i] - axis.origin - i * spacing) < 1e-6 * spacing;
    }
    const double slots = double(nSlots_[0]) * nSlots_[1] * nSlots_[2];
    if (slots > 1e9)
        throw std::runtime_error("the faces of the box cells of one rank make more than 1e9 lattice slots: "
                                 "use fewer different cell sizes, or more ranks");
    cellOf_.assign(std::size_t(slots), -1);
    for (int c = 0; c < nCells_; ++c)
    {
        std::array<int, 3> first, last;
        for (int a = 0; a < 3; ++a)
        {
            first[a] = nearest(axis_[a].face, boxes[c].low[a]);
            last[a] = nearest(axis_[a].face, boxes[c].high[a]);
        }
        for (int k = first[2]; k < last[2]; ++k)
            for (int j = first[1]; j < last[1]; ++j)
                for (int i = first[0]; i < last[0]; ++i) cellOf_[slot(i, j, k)] = c;
    }
}

Box BoxCells::bounds() const
{
    Box box;
    if (nCells_ == 0) return box;
    for (int a = 0; a < 3; ++a)
    {
        box.low[a] = axis_[a].face.front();
        box.high[a] = axis_[a].face.back();
    }
    return box;
}

int BoxCells::Axis::interval(double x) const
{
    const int last = int(face.size()) - 2;
    if (uniform)
    {
        int i = int(std::clamp((x - origin) * inverseSpacing, 0.0, double(last)));
        // the quotient is rounded; the faces decide
        if (i > 0 && x < face[i]) --i;
        if (i < last && x >= face[i + 1]) ++i;
        return i;
    }
    const int above = int(std::upper_bound(face.begin(), face.end(), x) - face.begin());
    return std::clamp(above - 1, 0, last);
}

bool BoxCells::contains(const Point& x) const
{
    if (nCells_ == 0) return false;
    std::array<int, 3> i;
    for (int a = 0; a < 3; ++a)
    {
        if (!(x[a] >= axis_[a].face.front() && x[a] <= axis_[a].face.back())) return false;
        i[a] = axis_[a].interval(x[a]);
    }
    return cellOf_[slot(i[0], i[1], i[2])] >= 0;
}

void BoxCells::append(const Point& x, double halfWidth, CellMass& out) const
{
    if (nCells_ == 0) return;
    constexpr int onStack = 64;
    std::array<std::array<double, onStack>, 3> small;
    std::array<std::vector<double>, 3> large; // kernels of very many cells only
    std::array<double*, 3> mass;
    std::array<int, 3> first, count;
    const double inverse = 1.0 / halfWidth;
    for (int a = 0; a < 3; ++a)
    {
        const Axis& axis = axis_[a];
        if (x[a] + halfWidth <= axis.face.front() || x[a] - halfWidth >= axis.face.back()) return;
        first[a] = axis.interval(x[a] - halfWidth);
        count[a] = axis.interval(x[a] + halfWidth) - first[a] + 1;
        mass[a] = small[a].data();
        if (count[a] > onStack)
        {
            large[a].resize(count[a]);
            mass[a] = large[a].data();
        }
        const double* face = &axis.face[first[a]];
        double below = deenMassBelow((face[0] - x[a]) * inverse);
        for (int i = 0; i < count[a]; ++i)
        {
            const double above = deenMassBelow((face[i + 1] - x[a]) * inverse);
            mass[a][i] = above - below;
            below = above;
        }
        if (empty(domain_)) continue;
        for (const double wall : {domain_.low[a], domain_.high[a]})
        {
            if (std::abs(x[a] - wall) >= halfWidth) continue;
            const double image = 2.0 * wall - x[a]; // the mirrored kernel reaches back into the domain
            for (int i = 0; i < count[a]; ++i)
                mass[a][i] +=
                    deenMassBelow((face[i + 1] - image) * inverse) - deenMassBelow((face[i] - image) * inverse);
        }
    }
    for (int k = 0; k < count[2]; ++k)
        for (int j = 0; j < count[1]; ++j)
        {
            const double jk = mass[1][j] * mass[2][k];
            const int* cell = &cellOf_[slot(first[0], first[1] + j, first[2] + k)];
            for (int i = 0; i < count[0]; ++i)
            {
                const double w = mass[0][i] * jk;
                if (cell[i] < 0 || !(w > 0.0)) continue;
                out.cell.push_back(cell[i]);
                out.mass.push_back(w);
            }
        }
}

SampledCells::SampledCells(int size, const Box& bounds, Locate locate, int samplesPerAxis)
    : size_(size), bounds_(bounds), locate_(std::move(locate)), node_(samplesPerAxis)
{
    // the middle (in mass) of samplesPerAxis strips of equal mass, by bisection of the kernel's integral
    for (int s = 0; s < samplesPerAxis; ++s)
    {
        const double target = (s + 0.5) / samplesPerAxis;
        double low = -1.0, high = 1.0;
        for (int halving = 0; halving < 60; ++halving)
        {
            const double middle = 0.5 * (low + high);
            (deenMassBelow(middle) < target ? low : high) = middle;
        }
        node_[s] = 0.5 * (low + high);
    }
}

void SampledCells::append(const Point& x, double halfWidth, CellMass& out) const
{
    const double share = 1.0 / (double(node_.size()) * double(node_.size()) * double(node_.size()));
    const std::size_t begin = out.cell.size();
    for (const double nz : node_)
        for (const double ny : node_)
            for (const double nx : node_)
            {
                const int cell = locate_({{x[0] + nx * halfWidth, x[1] + ny * halfWidth, x[2] + nz * halfWidth}});
                if (cell < 0) continue;
                const auto known = std::find(out.cell.begin() + std::ptrdiff_t(begin), out.cell.end(), cell);
                if (known != out.cell.end())
                    out.mass[std::size_t(known - out.cell.begin())] += share;
                else
                {
                    out.cell.push_back(cell);
                    out.mass.push_back(share);
                }
            }
}

} // namespace hotbed
