#include "cells.hpp"
#include "deen_kernel.hpp"
#include "lattice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

using namespace hotbed;

namespace
{

std::vector<double> faces(int n, double low, double high, double grading)
{
    std::vector<double> face(n + 1);
    for (int i = 0; i <= n; ++i) face[i] = low + (high - low) * std::pow(double(i) / n, grading);
    return face;
}

std::vector<Box> grid(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z)
{
    std::vector<Box> boxes;
    for (std::size_t k = 0; k + 1 < z.size(); ++k)
        for (std::size_t j = 0; j + 1 < y.size(); ++j)
            for (std::size_t i = 0; i + 1 < x.size(); ++i)
                boxes.push_back({{{x[i], y[j], z[k]}}, {{x[i + 1], y[j + 1], z[k + 1]}}});
    return boxes;
}

const Box unit{{{0, 0, 0}}, {{1, 1, 1}}};

/// cells' values to all particles
void interpolate(Weights& weights, int fields, const double* cells, double* particles)
{
    weights.interpolate(fields, 0, weights.size(), weights.read(fields, cells), particles);
}

/// all particles' values added to the cells
void deposit(Weights& weights, int fields, const double* particles, double* cells)
{
    weights.deposit(fields, 0, weights.size(), particles, weights.sums(fields, cells));
    weights.passOn(fields, cells);
}

std::map<int, double> masses(const Cells& cells, const Point& x, double n)
{
    const auto weights = cells.weights();
    const double position[1][3] = {{x[0], x[1], x[2]}}, one = 1.0;
    double found, centre;
    weights->append(1, position, &n, &found, &centre);
    std::vector<double> deposited(cells.size(), 0.0);
    deposit(*weights, 1, &one, deposited.data());
    std::map<int, double> mass;
    double sum = 0.0;
    for (int c = 0; c < cells.size(); ++c)
    {
        sum += deposited[c];
        if (deposited[c] > 0.0) mass[c] = deposited[c];
    }
    EXPECT_NEAR(found, sum, 1e-14);
    return mass;
}

double sum(const std::map<int, double>& mass)
{
    return std::accumulate(mass.begin(), mass.end(), 0.0, [](double s, const auto& e) { return s + e.second; });
}

/// Simpson integration of Deen's polynomial itself, to compare the closed form with
double integrated(double from, double to)
{
    from = std::max(from, -1.0);
    to = std::min(to, 1.0);
    if (from >= to) return 0.0;
    const int steps = 400;
    const double h = (to - from) / steps;
    double s = 0.0;
    for (int i = 0; i <= steps; ++i)
    {
        const double x = from + i * h;
        s += std::pow(1 - x * x, 2) * (i == 0 || i == steps ? 1 : i % 2 ? 4 : 2);
    }
    return 15.0 / 16.0 * s * h / 3.0;
}

} // namespace

TEST(DeenKernel, ClosedFormIsTheIntegralOfThePolynomial)
{
    for (double x = -1.2; x < 1.2; x += 0.07) EXPECT_NEAR(deenMassBelow(x), integrated(-1, x), 1e-9) << x;
    EXPECT_NEAR(deenMassBelow(-7), 0.0, 3e-16);
    EXPECT_NEAR(deenMassBelow(7), 1.0, 3e-16);
}

TEST(BoxCells, MassIsTheProductOfOneDimensionalIntegrals)
{
    for (const double grading : {1.0, 1.6})
    {
        const auto x = faces(7, 0, 1, grading), y = faces(5, 0, 1, 1.0), z = faces(9, 0, 1, grading);
        const BoxCells cells(grid(x, y, z), Box{});
        const Point at{{0.43, 0.52, 0.61}};
        const double n = 0.31;
        const auto mass = masses(cells, at, n);
        for (const auto& [c, m] : mass)
        {
            const int i = c % 7, j = c / 7 % 5, k = c / 35;
            EXPECT_NEAR(m,
                        integrated((x[i] - at[0]) / n, (x[i + 1] - at[0]) / n) *
                            integrated((y[j] - at[1]) / n, (y[j + 1] - at[1]) / n) *
                            integrated((z[k] - at[2]) / n, (z[k + 1] - at[2]) / n),
                        1e-9);
        }
        EXPECT_NEAR(sum(mass), 1.0, 1e-13);
    }
}

TEST(BoxCells, CellsOfDifferentSizesSideBySide)
{
    // a coarse half beside a fine half: no tensor grid
    auto boxes = grid(faces(2, 0, 0.5, 1), faces(4, 0, 1, 1), faces(4, 0, 1, 1));
    const auto fine = grid(faces(5, 0.5, 1, 1), faces(7, 0, 1, 1), faces(3, 0, 1, 1));
    boxes.insert(boxes.end(), fine.begin(), fine.end());
    const BoxCells cells(boxes, Box{});
    EXPECT_NEAR(sum(masses(cells, {{0.5, 0.5, 0.5}}, 0.3)), 1.0, 1e-13);
    double total = 0.0;
    for (int c = 0; c < cells.size(); ++c) total += masses(cells, {{0.45, 0.5, 0.5}}, 0.2)[c];
    EXPECT_NEAR(total, 1.0, 1e-13);
}

TEST(BoxCells, KernelIsFoldedBackAtTheWallsOfABox)
{
    const BoxCells folded(grid(faces(8, 0, 1, 1), faces(8, 0, 1, 1), faces(8, 0, 1, 1)), unit);
    const BoxCells cut(grid(faces(8, 0, 1, 1), faces(8, 0, 1, 1), faces(8, 0, 1, 1)), Box{});
    for (const Point& x : {Point{{0.01, 0.5, 0.5}}, Point{{0.01, 0.99, 0.02}}, Point{{0, 0, 0}}, Point{{1, 1, 1}}})
    {
        EXPECT_NEAR(sum(masses(folded, x, 0.2)), 1.0, 1e-13);
        EXPECT_LT(sum(masses(cut, x, 0.2)), 0.7);
    }
}

TEST(BoxCells, EvenPackingHasEvenVoidageUpToTheWalls)
{
    const BoxCells cells(grid(faces(10, 0, 1, 1), faces(1, 0, 1, 1), faces(1, 0, 1, 1)), unit);
    std::map<int, double> solids;
    const int particles = 40;
    for (int i = 0; i < particles; ++i)
        for (const auto& [c, m] : masses(cells, {{(i + 0.5) / particles, 0.5, 0.5}}, 0.12)) solids[c] += m;
    for (const auto& [c, s] : solids) EXPECT_NEAR(s, 4.0, 0.004) << c;
}

TEST(BoxCells, ContainsItsSurfaceAndNothingBeyond)
{
    const BoxCells cells(grid(faces(3, 0, 1, 1), faces(3, 0, 1, 1), faces(3, 0, 1, 1)), unit);
    EXPECT_TRUE(cells.contains({{0, 0, 0}}));
    EXPECT_TRUE(cells.contains({{1, 1, 1}}));
    EXPECT_TRUE(cells.contains({{1.0 / 3, 2.0 / 3, 0.4}}));
    EXPECT_FALSE(cells.contains({{1.0001, 0.5, 0.5}}));
    EXPECT_FALSE(cells.contains({{0.5, -1e-9, 0.5}}));
    EXPECT_FALSE(cells.contains({{0.5, 0.5, std::nan("")}}));
}

TEST(BoxCells, RankWithoutCells)
{
    const BoxCells none({}, unit);
    EXPECT_TRUE(masses(none, {{0.5, 0.5, 0.5}}, 0.2).empty());
    EXPECT_FALSE(none.contains({{0.5, 0.5, 0.5}}));
    EXPECT_GT(none.bounds().low[0], none.bounds().high[0]);
}

TEST(LatticeCells, ConvergesToTheExactIntegrals)
{
    const auto boxes = grid(faces(6, 0, 1, 1), faces(6, 0, 1, 1), faces(6, 0, 1, 1));
    const Point at{{0.47, 0.52, 0.38}};
    const auto reference = masses(BoxCells(boxes, Box{}), at, 0.25);
    const auto error = [&](int n)
    {
        const auto mass = masses(*throughLattice(boxes, {{n, n, n}}), at, 0.25);
        EXPECT_NEAR(sum(mass), 1.0, 1e-13);
        double difference = 0.0;
        for (const auto& [c, m] : reference) difference += std::abs(m - (mass.count(c) ? mass.at(c) : 0.0));
        return difference;
    };
    EXPECT_LT(error(12), 1e-13) << "planes of the lattice on all faces of the cells";
    double before = error(5);
    for (const int n : {11, 23, 47}) // none of them on the faces between cells
    {
        const double now = error(n);
        EXPECT_LT(now, 0.5 * before) << n;
        before = now;
    }
    EXPECT_LT(before, 0.01);
}

TEST(LatticeCells, ContainsTheBoxesThatHoldAPieceOfACell)
{
    const auto cells = throughLattice({{{{0, 0, 0}}, {{0.55, 1, 1}}}}, {{10, 10, 10}});
    EXPECT_TRUE(cells->contains({{0.5, 0.5, 0.5}}));
    EXPECT_TRUE(cells->contains({{0.599, 0, 1}}));
    EXPECT_FALSE(cells->contains({{0.601, 0.5, 0.5}}));
    EXPECT_FALSE(cells->contains({{0.5, -1e-9, 0.5}}));
    EXPECT_FALSE(cells->contains({{0.5, 0.5, std::nan("")}}));
}

TEST(Weights, PlacesOfCellsInWideGrids)
{
    for (const int n : {63, 64, 128})
    {
        const auto x = faces(n, 0, 1, 1), face = faces(4, 0, 1, 1);
        const BoxCells boxes(grid(x, face, face), unit);
        const auto lattice = throughLattice(grid(faces(2, 0, 1, 1), face, face), {{n, 4, 4}});
        const double position[1][3] = {{0.5, 0.55, 0.4}}, halfWidth[1] = {0.4};
        double found[1], centre[1];
        for (const Cells* cells : {static_cast<const Cells*>(&boxes), static_cast<const Cells*>(lattice.get())})
        {
            const auto weights = cells->weights();
            weights->append(1, position, halfWidth, found, centre);
            // the mean of the cells' centres is the particle's place but for what cells smear out, also weighted back
            const int nx = cells->size() / 16;
            std::vector<double> at(std::size_t(cells->places())), sum(at);
            for (int c = 0; c < cells->size(); ++c) at[std::size_t(cells->place(c))] = (c % nx + 0.5) / nx;
            double mean, one = 1.0, deposited = 0.0, total = 0.0;
            interpolate(*weights, 1, at.data(), &mean);
            deposit(*weights, 1, &one, sum.data());
            for (int c = 0; c < cells->size(); ++c)
            {
                const auto place = std::size_t(cells->place(c));
                total += sum[place];
                deposited += sum[place] * at[place];
            }
            EXPECT_NEAR(mean, 0.5, 1e-12) << n;
            EXPECT_NEAR(deposited, 0.5, 1e-12) << n;
            EXPECT_NEAR(total, 1.0, 1e-12) << n;
        }
        EXPECT_NE(boxes.place(n) % 64, 0) << n;
    }
}

TEST(Weights, SeveralFieldsAtATimeGiveWhatOneDoes)
{
    const auto face = faces(6, 0, 1, 1);
    const BoxCells boxes(grid(face, face, face), unit);
    const auto lattice = throughLattice(grid(face, face, faces(3, 0, 1, 1.6)), {{7, 5, 4}});
    for (const Cells* cells : {static_cast<const Cells*>(&boxes), static_cast<const Cells*>(lattice.get())})
    {
        const auto weights = cells->weights();
        constexpr std::size_t n = 3;
        const double position[n][3] = {{0.1, 0.5, 0.9}, {0.33, 0.4, 0.45}, {0.6, 0.02, 0.7}},
                     halfWidth[n] = {0.3, 0.3, 0.3};
        double found[n], centre[n];
        weights->append(int(n), position, halfWidth, found, centre);
        const std::size_t m = std::size_t(cells->size());
        for (const int fields : {1, 2, 8, 12})
        {
            const auto entry = [](std::size_t row, int f) { return std::sin(1.0 + double(row) + 100.0 * f); };
            std::vector<double> cellValue, particleValue;
            for (std::size_t c = 0; c < m; ++c)
                for (int f = 0; f < fields; ++f) cellValue.push_back(entry(c, f));
            for (std::size_t i = 0; i < n; ++i)
                for (int f = 0; f < fields; ++f) particleValue.push_back(entry(i, f));
            std::vector<double> read(n * fields), sum(m * fields, 0.0), one(m), readOne(n);
            interpolate(*weights, fields, cellValue.data(), read.data());
            deposit(*weights, fields, particleValue.data(), sum.data());
            for (int f = 0; f < fields; ++f)
            {
                for (std::size_t c = 0; c < m; ++c) one[c] = entry(c, f);
                interpolate(*weights, 1, one.data(), readOne.data());
                for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(read[i * fields + f], readOne[i], 1e-15);
                std::vector<double> given(n), sumOne(m, 0.0);
                for (std::size_t i = 0; i < n; ++i) given[i] = entry(i, f);
                deposit(*weights, 1, given.data(), sumOne.data());
                for (std::size_t c = 0; c < m; ++c) EXPECT_NEAR(sum[c * fields + f], sumOne[c], 1e-15);
            }
        }
    }
}
