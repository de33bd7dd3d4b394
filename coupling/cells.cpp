#include "cells.hpp"

#include "deen_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
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

BoxCells::BoxCells(const std::vector<Box>& boxes, const Box& domain) : nCells_(int(boxes.size()))
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
        BoxAxis& axis = axis_[a];
        axis.face = distinct(std::move(all), 1e-6 * smallest);
        nSlots_[a] = int(axis.face.size()) - 1;
        axis.origin = axis.face.front();
        const double spacing = (axis.face.back() - axis.face.front()) / nSlots_[a];
        axis.inverseSpacing = 1.0 / spacing;
        axis.folded = !empty(domain);
        axis.wall = {domain.low[a], domain.high[a]};
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
    full_ = std::find(cellOf_.begin(), cellOf_.end(), -1) == cellOf_.end();
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

bool BoxCells::contains(const Point& x) const
{
    if (nCells_ == 0) return false;
    for (int a = 0; a < 3; ++a)
        if (!(x[a] >= axis_[a].face.front() && x[a] <= axis_[a].face.back())) return false;
    return full_ || cellOf_[slot(axis_[0].interval(x[0]), axis_[1].interval(x[1]), axis_[2].interval(x[2]))] >= 0;
}

class BoxCells::Products : public Weights
{
public:
    explicit Products(const BoxCells& cells) : cells_(cells)
    {
        weights_.cellOf = cells.cellOf_.data();
        weights_.nx = cells.nSlots_[0];
        weights_.nxy = cells.nSlots_[0] * cells.nSlots_[1];
    }

    void clear() override { weights_.clear(); }

    void append(int count, const double (*particles)[4], double (*found)[2]) override
    {
        const std::size_t first = weights_.particle.size();
        if (cells_.nCells_ == 0)
        {
            weights_.particle.resize(first + std::size_t(count));
            std::fill_n(&found[0][0], 2 * count, 0.0);
            return;
        }
        weights_.append(cells_.axis_, count, particles, found);
        for (int n = 0; n < count; ++n)
        {
            const double* x = particles[n];
            if (!cells_.full_) found[n][0] = weights_.mass(weights_.particle[first + std::size_t(n)]);
            found[n][1] = cells_.contains({{x[0], x[1], x[2]}}) ? 1.0 : 0.0;
        }
    }

    void scale(int first, int count, const double* factor) override
    {
        for (int n = first; n < first + count; ++n, ++factor)
        {
            const BoxWeights::Particle& p = weights_.particle[std::size_t(n)];
            double* x = weights_.row.data() + p.row;
            for (int i = 0; i < p.count[0]; ++i) x[i] *= *factor;
        }
    }

    int size() const override { return int(weights_.particle.size()); }

    void interpolate(int fields, int first, int count, const double* cells, double* particles) const override
    {
        hotbed::interpolate(fields, weights_, first, count, cells, particles);
    }

    void deposit(int fields, int first, int count, const double* particles, double* cells) const override
    {
        hotbed::deposit(fields, weights_, first, count, particles, cells);
    }

private:
    const BoxCells& cells_;
    BoxWeights weights_;
};

std::unique_ptr<Weights> BoxCells::weights() const
{
    return std::make_unique<Products>(*this);
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

class SampledCells::List : public Weights
{
public:
    explicit List(const SampledCells& cells) : cells_(cells) {}

    void clear() override
    {
        start_.assign(1, 0);
        cell_.clear();
        weight_.clear();
    }

    void append(int count, const double (*particles)[4], double (*found)[2]) override
    {
        for (int n = 0; n < count; ++n)
        {
            const auto begin = start_.back();
            sample(particles[n], particles[n][3]);
            found[n][0] = std::accumulate(weight_.begin() + begin, weight_.end(), 0.0);
            found[n][1] = cells_.contains({{particles[n][0], particles[n][1], particles[n][2]}}) ? 1.0 : 0.0;
        }
    }

    void scale(int first, int count, const double* factor) override
    {
        for (auto k = std::size_t(first); k < std::size_t(first + count); ++k, ++factor)
            for (auto e = start_[k]; e < start_[k + 1]; ++e) weight_[e] *= *factor;
    }

    int size() const override { return int(start_.size()) - 1; }

    void interpolate(int fields, int first, int count, const double* cells, double* particles) const override
    {
        for (auto k = std::size_t(first); k < std::size_t(first + count); ++k, particles += fields)
        {
            std::fill_n(particles, fields, 0.0);
            for (auto e = start_[k]; e < start_[k + 1]; ++e)
                for (int f = 0; f < fields; ++f)
                    particles[f] += weight_[e] * cells[std::size_t(cell_[e]) * std::size_t(fields) + f];
        }
    }

    void deposit(int fields, int first, int count, const double* particles, double* cells) const override
    {
        for (auto k = std::size_t(first); k < std::size_t(first + count); ++k, particles += fields)
            for (auto e = start_[k]; e < start_[k + 1]; ++e)
                for (int f = 0; f < fields; ++f)
                    cells[std::size_t(cell_[e]) * std::size_t(fields) + f] += weight_[e] * particles[f];
    }

private:
    void sample(const double* x, double halfWidth)
    {
        const auto& node = cells_.node_;
        const double share = 1.0 / (double(node.size()) * double(node.size()) * double(node.size()));
        const auto begin = std::ptrdiff_t(cell_.size());
        for (const double nz : node)
            for (const double ny : node)
                for (const double nx : node)
                {
                    const int cell =
                        cells_.locate_({{x[0] + nx * halfWidth, x[1] + ny * halfWidth, x[2] + nz * halfWidth}});
                    if (cell < 0) continue;
                    const auto known = std::find(cell_.begin() + begin, cell_.end(), cell);
                    if (known != cell_.end())
                        weight_[std::size_t(known - cell_.begin())] += share;
                    else
                    {
                        cell_.push_back(cell);
                        weight_.push_back(share);
                    }
                }
        start_.push_back(std::int64_t(cell_.size()));
    }

    const SampledCells& cells_;
    std::vector<std::int64_t> start_{0}; ///< entries of particle k: start_[k] to start_[k + 1]
    std::vector<int> cell_;
    std::vector<double> weight_;
};

std::unique_ptr<Weights> SampledCells::weights() const
{
    return std::make_unique<List>(*this);
}

} // namespace hotbed
