#pragma once

#include <mpi.h>

#include <iosfwd>
#include <map>
#include <string>

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

    /// @param phase name in the table; phases appear in the order of their names' first use
    Scope measure(const std::string& phase);

    /// The table: mean and largest time over the ranks, time a step, share of the whole. Collective; rank 0 writes.
    /// Phases must be the same on every rank.
    void print(std::ostream& out, MPI_Comm communicator, double total, long steps) const;

private:
    std::map<std::string, std::size_t> index_;
    std::map<std::size_t, std::pair<std::string, double>> phase_;
};

} // namespace hotbed
