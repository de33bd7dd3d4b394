#pragma once

#include <mpi.h>

#include <iosfwd>
#include <deque>
#include <string>
#include <utility>

namespace hotbed
{

/// Wall time by phase, for the table that closes every run.
class Timing
{
public:
    /// Times the scope it lives in.
    class Scope
    {
    public:
        explicit Scope(double& seconds) : seconds_(seconds), begin_(MPI_Wtime()) {}
        ~Scope() { seconds_ += MPI_Wtime() - begin_; }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        double& seconds_;
        double begin_;
    };

    /// @param phase name in the table; phases appear in the order of their names' first use. `a: b` is a
    ///              part of `a`, whose time it does not add to.
    Scope measure(const std::string& phase) { return Scope(seconds(phase)); }

    /// Adds time that was measured elsewhere.
    void add(const std::string& phase, double seconds) { this->seconds(phase) += seconds; }

    /// Time of a phase so far on this rank [s].
    double of(const std::string& phase) { return seconds(phase); }

    /// The table: mean and largest time over the ranks, time a step, share of the whole. Collective; rank 0 writes.
    /// Phases must be the same on every rank.
    void print(std::ostream& out, MPI_Comm communicator, double total, long steps) const;

private:
    double& seconds(const std::string& phase);

    std::deque<std::pair<std::string, double>> phase_; ///< in order of first use; references stay valid
};

} // namespace hotbed
