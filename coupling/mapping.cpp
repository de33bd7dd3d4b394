#include "mapping.hpp"

#include <algorithm>
#include <numeric>

namespace hotbed
{

Mapping::Mapping(MPI_Comm communicator, std::unique_ptr<const Cells> cells)
    : communicator_(communicator), cells_(std::move(cells)), weights_(cells_->weights())
{
    MPI_Comm_rank(communicator_, &rank_);
    MPI_Comm_size(communicator_, &ranks_);
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
            const double n = particles.halfWidth[i];
            bool reached = true;
            for (int a = 0; a < 3; ++a) reached = reached && x[a] + n > box.low[a] && x[a] - n < box.high[a];
            if (reached && box.low[0] <= box.high[0]) sendParticle_.push_back(i);
        }
        sendStart_[r + 1] = int(sendParticle_.size());
        sendCount[r] = sendStart_[r + 1] - sendStart_[r];
    }
    MPI_Alltoall(sendCount.data(), 1, MPI_INT, receiveCount.data(), 1, MPI_INT, communicator_);
    std::partial_sum(receiveCount.begin(), receiveCount.end(), receiveStart_.begin() + 1);
    direct_ = ranks_ == 1 && sendStart_[1] == particles.count;
}

std::vector<char> Mapping::update(const ParticlePositions& particles)
{
    particles_ = particles.count;
    route(particles);

    std::vector<double> home(std::size_t(particles_) * 4);
    for (int i = 0; i < particles_; ++i)
    {
        std::copy_n(particles.position[i], 3, &home[std::size_t(i) * 4]);
        home[std::size_t(i) * 4 + 3] = particles.halfWidth[i];
    }
    const auto* copy = reinterpret_cast<const double(*)[4]>(toCopies(4, home.data()));

    const int n = receiveStart_[ranks_];
    copyPosition_.resize(n);
    for (int k = 0; k < n; ++k) std::copy_n(copy[k], 3, copyPosition_[k].begin());
    std::vector<double> found(std::size_t(n) * 2); // kernel mass on this rank; cells that hold the centre
    weights_->assign(n, copy, reinterpret_cast<double(*)[2]>(found.data()));

    const double* total = toHome(2, found.data());
    std::vector<char> inside(particles_);
    std::vector<double> scale(particles_);
    for (int i = 0; i < particles_; ++i)
    {
        const double mass = total[std::size_t(i) * 2];
        inside[i] = total[std::size_t(i) * 2 + 1] > 0.0 && mass > 0.0;
        scale[i] = inside[i] ? 1.0 / mass : 0.0;
    }
    weights_->scale(toCopies(1, scale.data()));
    return inside;
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

} // namespace hotbed
