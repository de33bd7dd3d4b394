#include "cells.hpp"

#include "box_weights.hpp"
#include "deen_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <tuple>

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

std::vector<Box> boxesBetween(const std::array<std::vector<double>, 3>& face)
{
    std::vector<Box> boxes;
    for (std::size_t k = 1; k < face[2].size(); ++k)
        for (std::size_t j = 1; j < face[1].size(); ++j)
            for (std::size_t i = 1; i < face[0].size(); ++i)
                boxes.push_back(
                    {{{face[0][i - 1], face[1][j - 1], face[2][k - 1]}}, {{face[0][i], face[1][j], face[2][k]}}});
    return boxes;
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

class BoxCells::Products : public Weights
{
public:
    explicit Products(const BoxCells& cells) : cells_(cells)
    {
        weights_.cellOf = cells.cellOf_.data();
        weights_.nx = cells.nSlots_[0];
        weights_.nxy = cells.nSlots_[0] * cells.nSlots_[1];
    }

    void assign(int count, const double (*particles)[4], double (*found)[2]) override
    {
        weights_.particle.assign(std::size_t(count), BoxWeights::Particle());
        std::size_t end = 0;
        for (int n = 0; n < count; ++n)
        {
            const double* x = particles[n];
            const double halfWidth = x[3];
            found[n][0] = found[n][1] = 0.0;
            std::array<int, 3> first, cells;
            if (!cells_.reach(0, x[0], halfWidth, first[0], cells[0]) ||
                !cells_.reach(1, x[1], halfWidth, first[1], cells[1]) ||
                !cells_.reach(2, x[2], halfWidth, first[2], cells[2]))
                continue;
            const std::size_t needed = end + std::size_t(cells[0] + cells[1] + cells[2]);
            if (weights_.row.size() < needed) weights_.row.resize(2 * needed);
            double* row = &weights_.row[end];
            double mass = 1.0;
            for (int a = 0; a < 3; row += cells[a++])
                mass *= cells_.axisMasses(a, x[a], halfWidth, first[a], cells[a], row);
            BoxWeights::Particle& p = weights_.particle[n];
            p.row = std::int64_t(end);
            p.count = cells;
            p.slot = cells_.slot(first[0], first[1], first[2]);
            end = needed;
            found[n][0] = cells_.full_ ? mass : weights_.mass(p);
            found[n][1] = cells_.contains({{x[0], x[1], x[2]}}) ? 1.0 : 0.0;
        }
    }

    void scale(const double* factor) override
    {
        for (const BoxWeights::Particle& p : weights_.particle)
        {
            double* x = weights_.row.data() + p.row;
            for (int i = 0; i < p.count[0]; ++i) x[i] *= *factor;
            ++factor;
        }
    }

    void interpolate(int fields, const double* cells, double* particles) const override
    {
        hotbed::interpolate(fields, weights_, cells, particles);
    }

    void deposit(int fields, const double* particles, double* cells) const override
    {
        hotbed::deposit(fields, weights_, particles, cells);
    }

private:
    const BoxCells& cells_;
    BoxWeights weights_;
};

std::unique_ptr<Weights> BoxCells::weights() const
{
    return std::make_unique<Products>(*this);
}

bool BoxCells::reach(int a, double x, double halfWidth, int& first, int& count) const
{
    const Axis& axis = axis_[a];
    if (nCells_ == 0 || x + halfWidth <= axis.face.front() || x - halfWidth >= axis.face.back()) return false;
    first = axis.interval(x - halfWidth);
    count = axis.interval(x + halfWidth) - first + 1;
    return true;
}

double BoxCells::axisMasses(int a, double x, double halfWidth, int first, int count, double* mass) const
{
    const double inverse = 1.0 / halfWidth;
    const double* face = &axis_[a].face[first];
    double below = deenMassBelow((face[0] - x) * inverse);
    for (int i = 0; i < count; ++i)
    {
        const double above = deenMassBelow((face[i + 1] - x) * inverse);
        mass[i] = above - below;
        below = above;
    }
    for (const double wall : {domain_.low[a], domain_.high[a]})
    {
        if (empty(domain_) || std::abs(x - wall) >= halfWidth) continue;
        const double image = 2.0 * wall - x; // the mirrored kernel reaches back into the domain
        for (int i = 0; i < count; ++i)
            mass[i] += deenMassBelow((face[i + 1] - image) * inverse) - deenMassBelow((face[i] - image) * inverse);
    }
    return std::accumulate(mass, mass + count, 0.0);
}

LatticeCells::LatticeCells(int size, const std::array<std::vector<double>, 3>& face, std::vector<Share> shares,
                           std::vector<char> inside)
    : size_(size), face_(face), boxes_(boxesBetween(face), Box{}), inside_(std::move(inside)),
      shares_(std::move(shares))
{
    // in the order of the boxes, so that the loops go through memory once; one for each box and cell
    std::sort(shares_.begin(), shares_.end(),
              [](const Share& a, const Share& b) { return std::tie(a.box, a.cell) < std::tie(b.box, b.cell); });
    std::size_t last = 0;
    for (std::size_t s = 1; s < shares_.size(); ++s)
        if (shares_[s].box == shares_[last].box && shares_[s].cell == shares_[last].cell)
            shares_[last].part += shares_[s].part;
        else
            shares_[++last] = shares_[s];
    shares_.resize(std::min(shares_.size(), last + 1));
}

bool LatticeCells::contains(const Point& x) const
{
    if (boxes_.size() == 0) return false;
    std::size_t box = 0, stride = 1;
    for (int a = 0; a < 3; ++a)
    {
        const std::vector<double>& face = face_[a];
        if (!(x[a] >= face.front() && x[a] <= face.back())) return false;
        const auto above = std::upper_bound(face.begin() + 1, face.end() - 1, x[a]);
        box += std::size_t(above - face.begin() - 1) * stride;
        stride *= face.size() - 1;
    }
    return inside_[box];
}

class LatticeCells::Spread : public Weights
{
public:
    explicit Spread(const LatticeCells& cells) : cells_(cells), onBoxes_(cells.boxes_.weights()) {}

    void assign(int count, const double (*particles)[4], double (*found)[2]) override
    {
        onBoxes_->assign(count, particles, found);
        const std::vector<double> ones(std::size_t(cells_.size_), 1.0);
        std::vector<double> mass(count);
        interpolate(1, ones.data(), mass.data());
        for (int n = 0; n < count; ++n)
        {
            found[n][0] = mass[n];
            found[n][1] = cells_.contains({{particles[n][0], particles[n][1], particles[n][2]}}) ? 1.0 : 0.0;
        }
    }

    void scale(const double* factor) override { onBoxes_->scale(factor); }

    void interpolate(int fields, const double* cells, double* particles) const override
    {
        boxValues_.assign(std::size_t(cells_.boxes_.size()) * std::size_t(fields), 0.0);
        for (const Share& s : cells_.shares_)
            for (int f = 0; f < fields; ++f)
                boxValues_[std::size_t(s.box) * fields + f] += s.part * cells[std::size_t(s.cell) * fields + f];
        onBoxes_->interpolate(fields, boxValues_.data(), particles);
    }

    void deposit(int fields, const double* particles, double* cells) const override
    {
        boxValues_.assign(std::size_t(cells_.boxes_.size()) * std::size_t(fields), 0.0);
        onBoxes_->deposit(fields, particles, boxValues_.data());
        for (const Share& s : cells_.shares_)
            for (int f = 0; f < fields; ++f)
                cells[std::size_t(s.cell) * fields + f] += s.part * boxValues_[std::size_t(s.box) * fields + f];
    }

private:
    const LatticeCells& cells_;
    std::unique_ptr<Weights> onBoxes_;
    mutable std::vector<double> boxValues_; ///< [boxes][fields], what is on its way
};

std::unique_ptr<Weights> LatticeCells::weights() const
{
    return std::make_unique<Spread>(*this);
}

} // namespace hotbed
