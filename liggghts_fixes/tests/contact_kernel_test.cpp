#include "contact_kernel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

using namespace hotbed;

namespace
{

constexpr int across = 5, high = 1600, number = across * across * high, ghosts = 3;
constexpr double diameter = 1e-3, spacing = 0.98e-3;

/// A column of particles that overlap a little, sorted from bottom to top; three ghosts touch the lowest ones.
struct Column
{
    std::vector<double> x, v, omega, force, torque, radius, mass, springs;
    std::vector<int> flags, first; ///< of each particle: its first pair among flags and springs
    ContactPairs pairs;

    Column()
    {
        std::mt19937 random(1);
        std::normal_distribution<double> some;
        for (int n = 0; n < number + ghosts; ++n)
        {
            const int i = n % across, j = n / across % across, k = n < number ? n / across / across : -1;
            for (const int a : {i, j, k}) x.push_back(spacing * a + 0.01 * diameter * some(random));
            for (int a = 0; a < 3; ++a) v.push_back(0.1 * some(random));
            for (int a = 0; a < 3; ++a) omega.push_back(100.0 * some(random));
            radius.push_back(0.5 * diameter);
            mass.push_back(5e-7);
        }
        force.assign(3 * number, 0.0);
        torque.assign(3 * number, 0.0);
    }

    double distance(int i, int j) const
    {
        return std::hypot(x[3 * i] - x[3 * j], x[3 * i + 1] - x[3 * j + 1], x[3 * i + 2] - x[3 * j + 2]);
    }

    /// @param order  of the particles whose pairs are listed; each pair is listed with the earlier particle
    void list(const std::vector<int>& order)
    {
        struct Pair
        {
            int i, j;
        };
        std::vector<Pair> listed;
        first.assign(number + 1, 0);
        for (const int i : order)
        {
            const auto add = [&](int j)
            {
                if (distance(i, j) > 1.1 * diameter) return;
                listed.push_back({i, j});
                ++first[i + 1];
            };
            for (int j = i + 1; j < std::min(number, i + 2 * across * across); ++j) add(j);
            for (int j = number; j < number + ghosts; ++j) add(j);
        }
        std::partial_sum(first.begin(), first.end(), first.begin());
        springs.assign(3 * listed.size(), 0.0);
        flags.assign(listed.size(), 0);
        pairs.clear(3);
        std::vector<int> next = first;
        for (const auto [i, j] : listed)
        {
            const int p = next[i]++;
            pairs.add(i, j, 0, 0, &flags[p], &springs[3 * std::size_t(p)]);
        }
        arrange(pairs, number, number + ghosts);
    }

    /// Forces of some steps at the same places: the springs grow.
    /// @param add  to what is there
    void steps(int count = 3, bool add = true)
    {
        ContactRows memory;
        for (int n = 0; n < count; ++n) contactForces(particles(), pairs, step(add), memory);
    }

    /// A step whose forces are taken as soon as they are complete. @return how often
    int stepByParts()
    {
        std::vector<double> someForce(3 * (completeAtOnce + 1)), someTorque = someForce;
        ContactParticles some = particles();
        some.force = rows(someForce);
        some.torque = rows(someTorque);
        ContactStep parts = step(false);
        int before = 0, count = 0;
        parts.complete = [&](int from, int end)
        {
            EXPECT_EQ(from, before);
            EXPECT_GT(end, from);
            EXPECT_LE(end - from, completeAtOnce);
            std::copy_n(someForce.begin(), 3 * (end - from), force.begin() + 3 * from);
            std::copy_n(someTorque.begin(), 3 * (end - from), torque.begin() + 3 * from);
            // as they move: nothing reads them again
            for (auto* moved : {&x, &v, &omega}) std::fill_n(moved->begin() + 3 * from, 3 * (end - from), NAN);
            before = end;
            ++count;
        };
        ContactRows memory;
        contactForces(some, pairs, parts, memory);
        EXPECT_EQ(before, number);
        return count;
    }

private:
    static double (*rows(std::vector<double>& values))[3] { return reinterpret_cast<double(*)[3]>(values.data()); }

    static ContactStep step(bool add)
    {
        static const ContactConstants constants = {{500.0, 1e-3, 0.0, 0.1}, {150.0, 1e-3, 0.0, 1.0 / 150.0}};
        return {&constants, true, true, add, 1e-5, 1.01 * 1.01, 3, {}};
    }

    ContactParticles particles()
    {
        return {number,        number + ghosts, rows(x),     rows(v),     rows(omega),
                radius.data(), mass.data(),     rows(force), rows(torque)};
    }
};

/// Largest difference over the largest value
double apart(const std::vector<double>& a, const std::vector<double>& b)
{
    double difference = 0.0, largest = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k)
    {
        difference = std::max(difference, std::abs(a[k] - b[k]));
        largest = std::max(largest, std::abs(b[k]));
    }
    return difference / largest;
}

} // namespace

TEST(ContactKernel, rowsTakeTurnsAndForcesAreThoseOfAllRowsAtOnce)
{
    if (!canVectorise()) GTEST_SKIP() << "this processor has no AVX2";
    std::vector<int> order(number);
    std::iota(order.begin(), order.end(), 0);
    Column sorted, any;
    sorted.list(order);
    EXPECT_GT(sorted.pairs.blocks.size(), 10u);
    EXPECT_LT(sorted.pairs.ring, number / 10) << "rows of a few layers";
    std::shuffle(order.begin(), order.end(), std::mt19937(2));
    any.list(order);
    EXPECT_GT(any.pairs.blocks.size(), number / 2) << "springs of each particle lie elsewhere";
    EXPECT_GE(any.pairs.ring, number);

    sorted.steps();
    any.steps();
    EXPECT_GT(std::count(sorted.flags.begin(), sorted.flags.end(), 3), 2 * number) << "contacts";
    EXPECT_LT(apart(sorted.force, any.force), 1e-13);
    EXPECT_LT(apart(sorted.torque, any.torque), 1e-13);
    EXPECT_EQ(sorted.flags, any.flags);
    EXPECT_EQ(sorted.springs, any.springs);
}

TEST(ContactKernel, forcesAreSetOrAddedTo)
{
    if (!canVectorise()) GTEST_SKIP() << "this processor has no AVX2";
    std::vector<int> order(number - 2 * across * across); // the uppermost particles have no pairs
    std::iota(order.begin(), order.end(), 0);
    Column added, set;
    for (Column* column : {&added, &set}) column->list(order);
    std::fill(set.force.begin(), set.force.end(), 7.0);
    std::fill(set.torque.begin(), set.torque.end(), 7.0);
    added.steps(1);
    set.steps(1, false);
    EXPECT_EQ(set.force, added.force);
    EXPECT_EQ(set.torque, added.torque);
    EXPECT_EQ(set.force.back(), 0.0);
}

TEST(ContactKernel, forcesAreCompleteWhenTheyAreSaidToBe)
{
    if (!canVectorise()) GTEST_SKIP() << "this processor has no AVX2";
    std::vector<int> order(number - 2 * across * across); // the uppermost particles have no pairs
    std::iota(order.begin(), order.end(), 0);
    Column whole, byParts;
    for (Column* column : {&whole, &byParts}) column->list(order);
    whole.steps(1, false);
    EXPECT_GT(byParts.stepByParts(), number / completeAtOnce);
    EXPECT_EQ(byParts.force, whole.force);
    EXPECT_EQ(byParts.torque, whole.torque);
    EXPECT_EQ(byParts.springs, whole.springs);
}

TEST(ContactKernel, forcesOfTwoParticlesCancel)
{
    if (!canVectorise()) GTEST_SKIP() << "this processor has no AVX2";
    std::vector<int> order(number);
    std::iota(order.begin(), order.end(), 0);
    Column column;
    for (int k = 0; k < ghosts; ++k) column.x[3 * std::size_t(number + k)] = 1.0; // out of reach
    column.list(order);
    column.steps();
    for (int a = 0; a < 3; ++a)
    {
        double sum = 0.0, largest = 0.0;
        for (int i = 0; i < number; ++i)
        {
            sum += column.force[3 * std::size_t(i) + a];
            largest = std::max(largest, std::abs(column.force[3 * std::size_t(i) + a]));
        }
        EXPECT_LT(std::abs(sum), 1e-11 * largest * std::sqrt(number));
    }
}
