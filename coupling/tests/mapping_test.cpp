// Run on 1, 2 and 4 ranks. The gas is split in four ways, the particles in another one.

#include "lattice.hpp"
#include "mapping.hpp"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>
#include <random>

using namespace hotbed;

namespace
{

constexpr int nx = 9, ny = 7, nz = 12, particlesInAll = 900;
const Box unit{{{0, 0, 0}}, {{1, 1, 1}}};

int rank()
{
    int r;
    MPI_Comm_rank(MPI_COMM_WORLD, &r);
    return r;
}

int ranks()
{
    int n;
    MPI_Comm_size(MPI_COMM_WORLD, &n);
    return n;
}

/// rank of a cell: slabs along x, slabs along z, scattered, everything on the last rank
int owner(int split, int i, int j, int k)
{
    switch (split)
    {
    case 0:
        return i * ranks() / nx;
    case 1:
        return k * ranks() / nz;
    case 2:
        return (i + 3 * j + 7 * k) % ranks();
    default:
        return ranks() - 1;
    }
}

struct Mesh
{
    std::vector<Box> boxes;
    std::vector<int> global; ///< number of each cell in the whole mesh
};

Mesh mesh(int split, bool whole)
{
    Mesh m;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
            {
                if (!whole && owner(split, i, j, k) != rank()) continue;
                m.boxes.push_back({{{double(i) / nx, double(j) / ny, double(k) / nz}},
                                   {{(i + 1.0) / nx, (j + 1.0) / ny, (k + 1.0) / nz}}});
                m.global.push_back((k * ny + j) * nx + i);
            }
    return m;
}

/// particles as wide as their kernels
constexpr KernelWidth asRadius{1.0, 0.0};

struct Particles
{
    std::vector<std::array<double, 3>> x;
    std::vector<double> n;
    std::vector<int> id;

    ParticlePositions view() const
    {
        return {int(x.size()), reinterpret_cast<const double(*)[3]>(x.data()), n.data(), asRadius};
    }
};

/// the same particles whatever the number of ranks, some of them in corners, on faces and on rank boundaries
Particles particles(bool all)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> u(0, 1);
    Particles p;
    for (int id = 0; id < particlesInAll; ++id)
    {
        std::array<double, 3> x{{u(random), u(random), u(random)}};
        const double n = 0.02 + 0.3 * u(random) * u(random);
        if (id % 9 == 0) x = {{double(id % 2), double(id / 2 % 2), double(id / 4 % 2)}};
        if (id % 10 == 1) x[0] = double(id % nx) / nx;
        if (id % 10 == 2) x[2] = 0.5;
        if (!all && (id * 5 / 3) % ranks() != rank()) continue;
        p.x.push_back(x);
        p.n.push_back(n);
        p.id.push_back(id);
    }
    return p;
}

std::vector<double> cellField(const Mesh& m)
{
    std::vector<double> f;
    for (const int g : m.global)
    {
        f.push_back(1.0);
        f.push_back(std::sin(0.37 * g));
    }
    return f;
}

/// cells' values at the particles
std::vector<double> read(Mapping& mapping, int fields, const std::vector<double>& cells, std::size_t particles)
{
    std::vector<double> values(particles * std::size_t(fields));
    mapping.interpolate(fields, cells.data(),
                        [&](int first, int count, const double* some)
                        { std::copy_n(some, count * fields, &values[std::size_t(first * fields)]); });
    return values;
}

/// A value of each particle, and twice that, to the cells.
/// @param sums  values by cell: 2, or more, which must stay 0
Gift gift(const std::vector<double>& value, int sums)
{
    return {sums, [&value, sums](int first, int count, double* given)
            {
                std::fill_n(given, count * sums, 0.0);
                for (int k = 0; k < count; ++k)
                {
                    given[k * sums] = value[std::size_t(first + k)];
                    given[k * sums + sums - 1] = 2.0 * given[k * sums];
                }
            }};
}

} // namespace

/// the split, and whether the weights are exact on the boxes or go through a lattice
class MappingOnRanks : public ::testing::TestWithParam<std::tuple<int, bool>>
{
};

std::unique_ptr<const Cells> cellsOf(const Mesh& m, bool lattice)
{
    if (lattice) return throughLattice(m.boxes, {{13, 11, 8}});
    return std::make_unique<BoxCells>(m.boxes, unit);
}

TEST_P(MappingOnRanks, WeightsSumToOneAndValuesAreThoseOfOneRank)
{
    const auto [split, lattice] = GetParam();
    const Mesh mine = mesh(split, false), whole = mesh(split, true);
    const Particles p = particles(false), all = particles(true);
    Mapping parallel(MPI_COMM_WORLD, cellsOf(mine, lattice));
    Mapping serial(MPI_COMM_SELF, cellsOf(whole, lattice));
    // deposits: every cell gets what it gets on one rank
    std::vector<double> value, allValue;
    for (const int id : p.id) value.push_back(1.0 + id % 13);
    for (const int id : all.id) allValue.push_back(1.0 + id % 13);
    const std::size_t cells = mine.boxes.size(), allCells = whole.boxes.size();
    std::vector<double> sum(cells * 12), allSum(allCells * 12), answered(cells * 2), nothing(cells);
    const Gift given = gift(value, 12), allGiven = gift(allValue, 12);
    parallel.update(p.view(), &given, sum.data());
    serial.update(all.view(), &allGiven, allSum.data());
    for (const char inside : parallel.inside()) EXPECT_TRUE(inside);
    for (std::size_t c = 0; c < cells; ++c)
        for (std::size_t f = 0; f < 12; ++f)
            EXPECT_NEAR(sum[c * 12 + f], allSum[std::size_t(mine.global[c]) * 12 + f], 1e-11);

    // the same where they give after they have read
    parallel.answer(
        1, nothing.data(), [](int, int, const double*) {}, gift(value, 2), answered.data());
    for (std::size_t c = 0; c < cells; ++c)
        for (std::size_t f = 0; f < 2; ++f) EXPECT_NEAR(answered[c * 2 + f], sum[c * 12 + f * 11], 1e-11);

    const auto wholeField = cellField(whole), field = cellField(mine);
    const std::vector<double> expected = read(serial, 2, wholeField, all.x.size());
    const std::vector<double> got = read(parallel, 2, field, p.x.size());
    for (std::size_t i = 0; i < p.x.size(); ++i)
    {
        EXPECT_NEAR(got[2 * i], 1.0, 1e-13) << "particle " << p.id[i];
        EXPECT_NEAR(got[2 * i + 1], expected[2 * std::size_t(p.id[i]) + 1], 1e-12);
    }
}

INSTANTIATE_TEST_SUITE_P(Splits, MappingOnRanks, ::testing::Combine(::testing::Range(0, 4), ::testing::Bool()));

TEST(Mapping, ParticlesOutsideTheMeshAreFound)
{
    const Mesh mine = mesh(1, false);
    Mapping mapping(MPI_COMM_WORLD, std::make_unique<BoxCells>(mine.boxes, unit));
    const double x[3][3] = {{0.5, 0.5, 0.5}, {1.05, 0.5, 0.5}, {7, 7, 7}};
    const double n[3] = {0.2, 0.2, 0.2};
    mapping.update({rank() == 0 ? 3 : 0, x, n, asRadius});
    const auto& inside = mapping.inside();
    if (rank() == 0)
    {
        EXPECT_TRUE(inside[0]);
        EXPECT_FALSE(inside[1]);
        EXPECT_FALSE(inside[2]);
    }
}

TEST(Mapping, KernelWiderThanTheDomainStillSumsToOne)
{
    const Mesh mine = mesh(0, false);
    Mapping mapping(MPI_COMM_WORLD, std::make_unique<BoxCells>(mine.boxes, unit));
    const double x[1][3] = {{0.3, 0.9, 0.5}};
    const double n[1] = {5.0};
    mapping.update({rank() == 0 ? 1 : 0, x, n, asRadius});
    const std::vector<double> one(mine.boxes.size(), 1.0);
    const std::vector<double> got = read(mapping, 1, one, rank() == 0 ? 1 : 0);
    if (rank() == 0)
    {
        EXPECT_NEAR(got[0], 1.0, 1e-13);
    }
}

int main(int argc, char** argv)
{
    MPI_Init(&argc, &argv);
    feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW); // as OpenFOAM does
    ::testing::InitGoogleTest(&argc, argv);
    if (rank() != 0) // one report is enough; a failure elsewhere still sets the exit status
        delete ::testing::UnitTest::GetInstance()->listeners().Release(
            ::testing::UnitTest::GetInstance()->listeners().default_result_printer());
    int failed = RUN_ALL_TESTS(), anywhere = 0;
    MPI_Allreduce(&failed, &anywhere, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    MPI_Finalize();
    return anywhere;
}
