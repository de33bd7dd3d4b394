#include "mapping.hpp"

#include <algorithm>
#include <numeric>

namespace hotbed
{

namespace
{

int ranksOf(MPI_Comm communicator)
{
    int ranks;
    MPI_Comm_size(communicator, &ranks);
    return ranks;
}

} // namespace

Mapping::Mapping(MPI_Comm communicator, std::unique_ptr<const Cells> cells)
    : communicator_(communicator), ranks_(ranksOf(communicator)), cells_(std::move(cells)), weights_(cells_->weights()),
      direct_(ranks_ == 1)
{
    MPI_Comm_rank(communicator_, &rank_);
    bounds_.resize(ranks_);
    const Box mine = cells_->bounds();
    MPI_Allgather(&mine, 6, MPI_DOUBLE, bounds_.data(), 6, MPI_DOUBLE, communicator_);
    sendStart_.assign(ranks_ + 1, 0);
    receiveStart_.assign(ranks_ + 1, 0);
}

void Mapping::route(const ParticlePositions& particles)
{
    sendParticle_.clear();
    std::vector<int> sendCount(ranks_, 0), receiveCount(ranks_, 0);
    for (int r = 0; r < ranks_; ++r)
    {
        const Box& box = bounds_[r];
        for (int i = 0; i < particles.count; ++i)
        {
            const double* x = particles.position[i];
            const double n = particles.kernel.half(particles.radius[i]);
            bool reached = true;
            for (int a = 0; a < 3; ++a) reached = reached && x[a] + n > box.low[a] && x[a] - n < box.high[a];
            if (reached && box.low[0] <= box.high[0]) sendParticle_.push_back(i);
        }
        sendStart_[r + 1] = int(sendParticle_.size());
        sendCount[r] = sendStart_[r + 1] - sendStart_[r];
    }
    MPI_Alltoall(sendCount.data(), 1, MPI_INT, receiveCount.data(), 1, MPI_INT, communicator_);
    std::partial_sum(receiveCount.begin(), receiveCount.end(), receiveStart_.begin() + 1);
}

/// Weights of this rank's copies, as shares of all that their particles have on any rank.
void Mapping::weighCopies(const ParticlePositions& particles)
{
    route(particles);
    const int mine = particles.count, n = copies();
    std::vector<double> sent(std::size_t(mine) * 4), factor(std::size_t(mine), 0.0);
    for (int i = 0; i < mine; ++i)
    {
        std::copy_n(particles.position[i], 3, &sent[std::size_t(i) * 4]);
        sent[std::size_t(i) * 4 + 3] = particles.radius[i];
    }
    const double* copy = toCopies(4, sent.data());
    copyPosition_.resize(std::size_t(n));
    copyRadius_.resize(std::size_t(n));
    std::vector<double> halfWidth(copyRadius_.size()), mass(copyRadius_.size()), centre(copyRadius_.size());
    for (std::size_t k = 0; k < copyRadius_.size(); ++k, copy += 4)
    {
        std::copy_n(copy, 3, copyPosition_[k].begin());
        copyRadius_[k] = copy[3];
        halfWidth[k] = particles.kernel.half(copy[3]);
    }
    weights_->append(n, copyPositions(nullptr), halfWidth.data(), mass.data(), centre.data());
    std::vector<double> found(copyRadius_.size() * 2);
    for (std::size_t k = 0; k < copyRadius_.size(); ++k)
    {
        found[2 * k] = mass[k];
        found[2 * k + 1] = centre[k];
    }
    const double* total = toHome(2, found.data());
    for (std::size_t i = 0; i < factor.size(); ++i, total += 2)
    {
        inside_[i] = isInside(total[0], total[1]);
        if (inside_[i]) factor[i] = 1.0 / total[0];
    }
    weights_->scale(0, n, toCopies(1, factor.data()));
}

/// One rank: weights of the next particles; sets whether they are inside.
void Mapping::weigh(const ParticlePositions& particles, int first, int count)
{
    double halfWidth[block] = {};
    for (int k = 0; k < count; ++k) halfWidth[k] = particles.kernel.half(particles.radius[first + k]);
    weights_->appendShares(count, particles.position + first, halfWidth, inside_.data() + first);
}

const std::vector<char>& Mapping::update(const ParticlePositions& particles, double* volumes)
{
    particles_ = particles.count;
    inside_.resize(std::size_t(particles.count));
    weights_->clear();
    double largest = 0.0;
#pragma omp simd reduction(max : largest)
    for (int i = 0; i < particles.count; ++i) largest = particles.radius[i] > largest ? particles.radius[i] : largest;
    widest_ = particles.count ? particles.kernel.half(largest) : 0.0;
    if (!direct_) weighCopies(particles);
    const double* radius = direct_ ? particles.radius : copyRadius_.data();
    double* sums = volumes ? weights_->sums(1, volumes) : nullptr;
    double volume[block];
    for (int first = 0; first < copies(); first += block)
    {
        const int count = std::min(block, copies() - first);
        if (direct_) weigh(particles, first, count);
        if (!volumes) continue;
        for (int k = 0; k < count; ++k) volume[k] = sphereVolume(radius[first + k]);
        weights_->deposit(1, first, count, volume, sums);
    }
    if (volumes) weights_->passOn(1, volumes);
    return inside_;
}

void Mapping::exchange(int fields, const double* send, const std::vector<int>& sendStart, double* receive,
                       const std::vector<int>& receiveStart)
{
    std::vector<MPI_Request> requests;
    for (int r = 0; r < ranks_; ++r)
    {
        const int count = receiveStart[r + 1] - receiveStart[r];
        if (r == rank_ || count == 0) continue;
        requests.emplace_back();
        MPI_Irecv(receive + std::size_t(receiveStart[r]) * fields, count * fields, MPI_DOUBLE, r, 0, communicator_,
                  &requests.back());
    }
    for (int r = 0; r < ranks_; ++r)
    {
        const int count = sendStart[r + 1] - sendStart[r];
        const double* from = send + std::size_t(sendStart[r]) * fields;
        if (r == rank_)
        {
            std::copy_n(from, std::size_t(count) * fields, receive + std::size_t(receiveStart[r]) * fields);
            continue;
        }
        if (count == 0) continue;
        bytesSent_ += std::int64_t(count) * fields * std::int64_t(sizeof(double));
        requests.emplace_back();
        MPI_Isend(from, count * fields, MPI_DOUBLE, r, 0, communicator_, &requests.back());
    }
    MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

const double* Mapping::toCopies(int fields, const double* home)
{
    if (direct_) return home;
    sendBuffer_.resize(sendParticle_.size() * std::size_t(fields));
    for (std::size_t s = 0; s < sendParticle_.size(); ++s)
        std::copy_n(home + std::size_t(sendParticle_[s]) * fields, fields, &sendBuffer_[s * std::size_t(fields)]);
    receiveBuffer_.resize(std::size_t(receiveStart_[ranks_]) * fields);
    exchange(fields, sendBuffer_.data(), sendStart_, receiveBuffer_.data(), receiveStart_);
    return receiveBuffer_.data();
}

const double* Mapping::toHome(int fields, const double* copies)
{
    if (direct_) return copies;
    sendBuffer_.resize(sendParticle_.size() * std::size_t(fields));
    exchange(fields, copies, receiveStart_, sendBuffer_.data(), sendStart_);
    result_.assign(std::size_t(particles_) * fields, 0.0);
    for (std::size_t s = 0; s < sendParticle_.size(); ++s)
        for (int f = 0; f < fields; ++f)
            result_[std::size_t(sendParticle_[s]) * fields + f] += sendBuffer_[s * std::size_t(fields) + f];
    return result_.data();
}

const double* Mapping::interpolate(int fields, const double* cellValues)
{
    partial_.resize(std::size_t(copies()) * std::size_t(fields));
    weights_->interpolate(fields, cellValues, partial_.data());
    return toHome(fields, partial_.data());
}

void Mapping::interpolate(int fields, const double* cellValues, const Use& use)
{
    const double* all = direct_ ? nullptr : interpolate(fields, cellValues);
    partial_.resize(std::max(partial_.size(), std::size_t(block) * fields));
    const double* read = direct_ ? weights_->read(fields, cellValues) : nullptr;
    for (int first = 0; first < particles_; first += block)
    {
        const int count = std::min(block, particles_ - first);
        if (direct_) weights_->interpolate(fields, first, count, read, partial_.data());
        use(first, count, direct_ ? partial_.data() : all + std::size_t(first) * fields);
    }
}

void Mapping::answer(int fields, const double* cellValues, const Use& use, int givenFields, const double* given,
                     const Fill& fill, int sumFields, double* cellSums)
{
    filled_.resize(std::size_t(block) * sumFields);
    double* sums = weights_->sums(sumFields, cellSums);
    const auto deposit = [&](int first, int count, const double* from)
    {
        fill(first, count, from + std::size_t(first) * givenFields, filled_.data());
        weights_->deposit(sumFields, first, count, filled_.data(), sums);
    };
    interpolate(fields, cellValues,
                [&](int first, int count, const double* values)
                {
                    use(first, count, values);
                    if (direct_) deposit(first, count, given);
                });
    if (!direct_)
    {
        const double* from = toCopies(givenFields, given);
        for (int first = 0; first < copies(); first += block) deposit(first, std::min(block, copies() - first), from);
    }
    weights_->passOn(sumFields, cellSums);
}

} // namespace hotbed
