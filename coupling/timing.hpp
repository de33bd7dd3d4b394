#pragma once

#include <mpi.h>

#include <iosfwd>
#include <deque>
#include <string>

namespace hotbed
{

/// Wall time by phase, for the table that closes every run.
class Timing
{
public:
    /// @param waiting  seconds that this rank has spent waiting for others so far; null: none
    explicit Timing(double (*waiting)() = nullptr) : waiting_(waiting) {}

    struct Phase
    {
        std::string name;
        double seconds = 0.0, waiting = 0.0; ///< waiting: of these seconds
    };

    /// Times the scope it lives in.
    class Scope
    {
    public:
        Scope(Phase& phase, double (*waiting)())
            : phase_(phase), clock_(waiting), begin_(MPI_Wtime()), waited_(waiting ? waiting() : 0.0)
        {
        }
        ~Scope()
        {
            phase_.seconds += MPI_Wtime() - begin_;
            if (clock_) phase_.waiting += clock_() - waited_;
        }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        Phase& phase_;
        double (*clock_)();
        double begin_, waited_;
    };

    /// @param phase name in the table; phases appear in the order of their names' first use. `a: b` is a
    ///              part of `a`, whose time it does not add to.
    Scope measure(const std::string& phase) { return Scope(find(phase), waiting_); }

    /// Adds time that was measured elsewhere.
    void add(const std::string& phase, double seconds) { find(phase).seconds += seconds; }

    /// Time of a phase so far on this rank [s].
    double of(const std::string& phase) { return find(phase).seconds; }

    /// The same without the time in which it waited for other ranks [s].
    double busy(const std::string& phase) { return find(phase).seconds - find(phase).waiting; }

    /// The table: mean and largest time over the ranks, time a step, share of the whole. Collective; rank 0 writes.
    /// Phases must be the same on every rank.
    void print(std::ostream& out, MPI_Comm communicator, double total, long steps) const;

private:
    Phase& find(const std::string& phase);

    double (*const waiting_)();
    std::deque<Phase> phase_; ///< in order of first use; references stay valid
};

} // namespace hotbed
