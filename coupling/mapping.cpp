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

/// What the kernels of some particles reach.
Box reach(const ParticlePositions& particles, int first, int end)
{
    Box box = {{{1e300, 1e300, 1e300}}, {{-1e300, -1e300, -1e300}}};
    for (int i = first; i < end; ++i)
    {
        const double n = particles.kernel.half(particles.radius[i]);
        for (int a = 0; a < 3; ++a)
        {
            box.low[a] = std::min(box.low[a], particles.position[i][a] - n);
            box.high[a] = std::max(box.high[a], particles.position[i][a] + n);
        }
    }
    return box;
}

bool overlap(const Box& a, const Box& b)
{
    bool both = true;
    for (int d = 0; d < 3; ++d) both = both && a.high[d] > b.low[d] && a.low[d] < b.high[d];
    return both;
}

} // namespace

/// Goes through what is sent to guests in the order of this rank's particles, block by block.
class Mapping::Guests
{
public:
    explicit Guests(const Mapping& mapping) : mapping_(mapping), next_(mapping.sendStart_) {}

    /// visit(entry, particle) for all entries of particles before `end` that were not visited yet.
    template <class Visit> void upTo(int end, Visit&& visit)
    {
        for (std::size_t r = 0; r + 1 < next_.size(); ++r)
            for (int& e = next_[r]; e < mapping_.sendStart_[r + 1] && mapping_.sendParticle_[std::size_t(e)] < end; ++e)
                visit(std::size_t(e), mapping_.sendParticle_[std::size_t(e)]);
    }

private:
    const Mapping& mapping_;
    std::vector<int> next_; ///< entry, by rank
};

Mapping::Mapping(MPI_Comm communicator, std::unique_ptr<const Cells> cells)
    : communicator_(communicator), ranks_(ranksOf(communicator)), cells_(std::move(cells)), weights_(cells_->weights()),
      guestWeights_(cells_->weights())
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
    // particles that follow each other lie near each other: of most, and of most ranks, no one needs a look of its own
    std::vector<Box> reached;
    for (int first = 0; ranks_ > 1 && first < particles_; first += block)
        reached.push_back(reach(particles, first, std::min(first + block, particles_)));
    for (int r = 0; r < ranks_; ++r)
    {
        const bool other = r != rank_ && bounds_[r].low[0] <= bounds_[r].high[0];
        for (int first = 0; other && first < particles_; first += block)
        {
            if (!overlap(reached[std::size_t(first / block)], bounds_[r])) continue;
            for (int i = first; i < std::min(first + block, particles_); ++i)
                if (overlap(reach(particles, i, i + 1), bounds_[r])) sendParticle_.push_back(i);
        }
        sendStart_[r + 1] = int(sendParticle_.size());
        sendCount[r] = sendStart_[r + 1] - sendStart_[r];
    }
    MPI_Alltoall(sendCount.data(), 1, MPI_INT, receiveCount.data(), 1, MPI_INT, communicator_);
    std::partial_sum(receiveCount.begin(), receiveCount.end(), receiveStart_.begin() + 1);
    guests_ = receiveStart_.back();
}

/// Sets the kernel masses of the guests.
/// @return for each entry sent: kernel mass on that rank, and 1 where it holds the centre; until the next message
const double* Mapping::receiveGuests(const ParticlePositions& particles)
{
    sendBuffer_.resize(sendParticle_.size() * 4);
    for (std::size_t e = 0; e < sendParticle_.size(); ++e)
    {
        const std::size_t i = std::size_t(sendParticle_[e]);
        std::copy_n(particles.position[i], 3, &sendBuffer_[e * 4]);
        sendBuffer_[e * 4 + 3] = particles.radius[i];
    }
    const std::size_t n = std::size_t(guests_);
    receiveBuffer_.resize(n * 4);
    exchange(4, sendBuffer_.data(), sendStart_, receiveBuffer_.data(), receiveStart_);
    std::vector<Point> position(n);
    std::vector<double> halfWidth(n), mass(n), centre(n), found(n * 2);
    for (std::size_t k = 0; k < n; ++k)
    {
        const double* guest = &receiveBuffer_[k * 4];
        std::copy_n(guest, 3, position[k].begin());
        halfWidth[k] = particles.kernel.half(guest[3]);
    }
    guestWeights_->append(guests_, reinterpret_cast<const double(*)[3]>(position.data()), halfWidth.data(), mass.data(),
                          centre.data());
    for (std::size_t k = 0; k < n; ++k)
    {
        found[2 * k] = mass[k];
        found[2 * k + 1] = centre[k];
    }
    return fromGuests(2, found.data());
}

void Mapping::update(const ParticlePositions& particles, const Gift* gift, double* cellSums)
{
    particles_ = particles.count;
    inside_.resize(std::size_t(particles_));
    weights_->clear();
    guestWeights_->clear();
    route(particles);
    const double* found = receiveGuests(particles);
    sendFactor_.resize(sendParticle_.size());
    Guests incoming(*this), outgoing(*this), givers(*this);
    double* sums = gift ? weights_->sums(gift->sums, cellSums) : nullptr;
    double halfWidth[block], mass[block], centre[block], widest = 0.0;
    for (int first = 0; first < particles_; first += block)
    {
        const int count = std::min(block, particles_ - first);
#pragma omp simd reduction(max : widest)
        for (int k = 0; k < count; ++k)
        {
            halfWidth[k] = particles.kernel.half(particles.radius[first + k]);
            widest = halfWidth[k] > widest ? halfWidth[k] : widest;
        }
        std::fill_n(mass, count, 0.0);
        std::fill_n(centre, count, 0.0);
        incoming.upTo(first + count,
                      [&](std::size_t e, int i)
                      {
                          mass[i - first] += found[2 * e];
                          centre[i - first] += found[2 * e + 1];
                      });
        weights_->appendShares(count, particles.position + first, halfWidth, mass, centre, inside_.data() + first);
        outgoing.upTo(first + count, [&](std::size_t e, int i) { sendFactor_[e] = mass[i - first]; });
        if (gift) give(*gift, first, count, givers, sums);
    }
    widest_ = widest;
    if (gift) giveGuests(*gift, sums, cellSums);
}

/// What a block of this rank's particles gives to its cells, and to the messages to other ranks (sendBuffer_).
void Mapping::give(const Gift& gift, int first, int count, Guests& outgoing, double* sums)
{
    constexpr int part = Gift::part;
    const std::size_t fields = std::size_t(gift.sums);
    sendBuffer_.resize(sendParticle_.size() * fields);
    given_.resize(part * fields);
    for (const int end = first + count; first < end; first += part)
    {
        const int some = std::min(part, end - first);
        gift.give(first, some, given_.data());
        outgoing.upTo(first + some,
                      [&](std::size_t e, int i)
                      {
                          const double* values = &given_[std::size_t(i - first) * fields];
                          for (std::size_t f = 0; f < fields; ++f)
                              sendBuffer_[e * fields + f] = sendFactor_[e] * values[f];
                      });
        weights_->deposit(gift.sums, first, some, given_.data(), sums);
    }
}

/// What guests give, once all of this rank's particles have given.
void Mapping::giveGuests(const Gift& gift, double* sums, double* cellSums)
{
    receiveBuffer_.resize(std::size_t(guests_) * std::size_t(gift.sums));
    exchange(gift.sums, sendBuffer_.data(), sendStart_, receiveBuffer_.data(), receiveStart_);
    guestWeights_->deposit(gift.sums, 0, guests_, receiveBuffer_.data(), sums);
    weights_->passOn(gift.sums, cellSums);
}

void Mapping::exchange(int fields, const double* send, const std::vector<int>& sendStart, double* receive,
                       const std::vector<int>& receiveStart)
{
    std::vector<MPI_Request> requests;
    for (int r = 0; r < ranks_; ++r)
    {
        const int count = receiveStart[r + 1] - receiveStart[r];
        if (count == 0) continue;
        requests.emplace_back();
        MPI_Irecv(receive + std::size_t(receiveStart[r]) * fields, count * fields, MPI_DOUBLE, r, 0, communicator_,
                  &requests.back());
    }
    for (int r = 0; r < ranks_; ++r)
    {
        const int count = sendStart[r + 1] - sendStart[r];
        if (count == 0) continue;
        bytesSent_ += std::int64_t(count) * fields * std::int64_t(sizeof(double));
        requests.emplace_back();
        MPI_Isend(send + std::size_t(sendStart[r]) * fields, count * fields, MPI_DOUBLE, r, 0, communicator_,
                  &requests.back());
    }
    MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

/// @return for each entry sent [fields], until the next message
const double* Mapping::fromGuests(int fields, const double* guests)
{
    receiveBuffer_.resize(sendParticle_.size() * std::size_t(fields));
    exchange(fields, guests, receiveStart_, receiveBuffer_.data(), sendStart_);
    return receiveBuffer_.data();
}

void Mapping::interpolate(int fields, const double* cellValues, const Use& use)
{
    const double* read = weights_->read(fields, cellValues);
    guestPartial_.resize(std::size_t(guests_) * fields);
    guestWeights_->interpolate(fields, 0, guests_, read, guestPartial_.data());
    const double* found = fromGuests(fields, guestPartial_.data());
    partial_.resize(std::max(partial_.size(), std::size_t(block) * fields));
    Guests incoming(*this);
    for (int first = 0; first < particles_; first += block)
    {
        const int count = std::min(block, particles_ - first);
        weights_->interpolate(fields, first, count, read, partial_.data());
        incoming.upTo(first + count,
                      [&](std::size_t e, int i)
                      {
                          double* values = &partial_[std::size_t(i - first) * fields];
                          for (int f = 0; f < fields; ++f)
                              values[f] += sendFactor_[e] * found[e * std::size_t(fields) + f];
                      });
        use(first, count, partial_.data());
    }
}

void Mapping::answer(int fields, const double* cellValues, const Use& use, const Gift& gift, double* cellSums)
{
    double* sums = weights_->sums(gift.sums, cellSums);
    Guests outgoing(*this);
    interpolate(fields, cellValues,
                [&](int first, int count, const double* values)
                {
                    use(first, count, values);
                    give(gift, first, count, outgoing, sums);
                });
    giveGuests(gift, sums, cellSums);
}

} // namespace hotbed
