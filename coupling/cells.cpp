#include "cells.hpp"

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
        axis.spacing = spacing;
        axis.inverseSpacing = 1.0 / spacing;
        axis.folded = !empty(domain);
        axis.wall = {domain.low[a], domain.high[a]};
        axis.uniform = true;
        for (int i = 0; i <= nSlots_[a]; ++i)
            axis.uniform = axis.uniform && std::abs(axis.face[i] - axis.origin - i * spacing) < 1e-6 * spacing;
    }
    row_ = nSlots_[0] % 64 == 0 ? nSlots_[0] + 4 : nSlots_[0]; // 64 cells of 8 numbers are 4 KiB
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
    ordered_ = full_ && std::adjacent_find(cellOf_.begin(), cellOf_.end(), [](int a, int b) { return b != a + 1; }) ==
                            cellOf_.end();
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

void Weights::appendShares(int count, const double (*position)[3], const double* halfWidth, double* mass,
                           double* centre, char* inside)
{
    const int first = size();
    std::vector<double> ownMass(std::size_t(count), 0.0), ownCentre(ownMass);
    append(count, position, halfWidth, ownMass.data(), ownCentre.data());
    for (std::size_t k = 0; k < ownMass.size(); ++k)
    {
        const double total = ownMass[k] + mass[k];
        inside[k] = isInside(total, centre[k] += ownCentre[k]);
        mass[k] = inside[k] ? 1.0 / total : 0.0;
    }
    scale(first, count, mass);
}

class BoxCells::Products : public Weights
{
public:
    explicit Products(const BoxCells& cells) : cells_(cells)
    {
        if (!cells.ordered_) weights_.cellOf = cells.cellOf_.data();
        weights_.nx = cells.ordered_ ? cells.row_ : cells.nSlots_[0];
        weights_.nxy = weights_.nx * cells.nSlots_[1];
    }

    void clear() override { weights_.clear(); }

    void append(int count, const double (*position)[3], const double* halfWidth, double* mass, double* centre) override
    {
        const int first = weights_.particles;
        if (cells_.nCells_ == 0)
        {
            std::fill_n(weights_.room(count), count, BoxWeights::Particle{});
            weights_.rows.resize(std::size_t(weights_.particles) / BoxWeights::group + 1, {});
            std::fill_n(mass, count, 0.0);
            std::fill_n(centre, count, 0.0);
            return;
        }
        weights_.append(cells_.axis_, count, position, halfWidth, mass, centre);
        for (int n = 0; n < count && !cells_.full_; ++n)
        {
            const double* x = position[n];
            mass[n] = weights_.mass(first + n);
            centre[n] = cells_.contains({{x[0], x[1], x[2]}}) ? 1.0 : 0.0;
        }
    }

    void appendShares(int count, const double (*position)[3], const double* halfWidth, double* mass, double* centre,
                      char* inside) override
    {
        if (cells_.full_)
            weights_.appendShares(cells_.axis_, count, position, halfWidth, mass, centre, inside);
        else
            Weights::appendShares(count, position, halfWidth, mass, centre, inside);
    }

    void scale(int first, int count, const double* factor) override { weights_.scale(first, count, factor); }

    int size() const override { return weights_.particles; }

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
    covered_.assign(std::size_t(boxes_.places()), 0.0);
    for (Share& s : shares_)
    {
        s.box = boxes_.place(s.box);
        covered_[std::size_t(s.box)] += s.part;
    }
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

    void clear() override { onBoxes_->clear(); }

    void append(int count, const double (*position)[3], const double* halfWidth, double* mass, double* centre) override
    {
        const int first = size();
        onBoxes_->append(count, position, halfWidth, mass, centre);
        onBoxes_->interpolate(1, first, count, cells_.covered_.data(), mass);
        for (int n = 0; n < count; ++n)
            centre[n] = cells_.contains({{position[n][0], position[n][1], position[n][2]}}) ? 1.0 : 0.0;
    }

    void scale(int first, int count, const double* factor) override { onBoxes_->scale(first, count, factor); }

    int size() const override { return onBoxes_->size(); }

    void interpolate(int fields, int first, int count, const double* boxes, double* particles) const override
    {
        onBoxes_->interpolate(fields, first, count, boxes, particles);
    }

    void deposit(int fields, int first, int count, const double* particles, double* boxes) const override
    {
        onBoxes_->deposit(fields, first, count, particles, boxes);
    }

    const double* read(int fields, const double* cells) override
    {
        boxValues_.assign(std::size_t(cells_.boxes_.places()) * std::size_t(fields), 0.0);
        for (const Share& s : cells_.shares_)
            for (int f = 0; f < fields; ++f)
                boxValues_[std::size_t(s.box) * fields + f] += s.part * cells[std::size_t(s.cell) * fields + f];
        return boxValues_.data();
    }

    double* sums(int fields, double*) override
    {
        boxSums_.assign(std::size_t(cells_.boxes_.places()) * std::size_t(fields), 0.0);
        return boxSums_.data();
    }

    void passOn(int fields, double* cells) override
    {
        for (const Share& s : cells_.shares_)
            for (int f = 0; f < fields; ++f)
                cells[std::size_t(s.cell) * fields + f] += s.part * boxSums_[std::size_t(s.box) * fields + f];
    }

private:
    const LatticeCells& cells_;
    std::unique_ptr<Weights> onBoxes_;
    std::vector<double> boxValues_, boxSums_; ///< [places][fields], what is on its way from and to the cells
};

std::unique_ptr<Weights> LatticeCells::weights() const
{
    return std::make_unique<Spread>(*this);
}

} // namespace hotbed
