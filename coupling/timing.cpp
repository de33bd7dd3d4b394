#include "timing.hpp"

#include <iomanip>
#include <ostream>

namespace hotbed
{

Timing::Phase& Timing::find(const std::string& phase)
{
    for (Phase& known : phase_)
        if (known.name == phase) return known;
    phase_.push_back({phase});
    return phase_.back();
}

void Timing::print(std::ostream& out, MPI_Comm communicator, double total, long steps) const
{
    int rank = 0, ranks = 1;
    MPI_Comm_rank(communicator, &rank);
    MPI_Comm_size(communicator, &ranks);
    const auto line = [&](const std::string& name, double mine)
    {
        double sum = 0.0, largest = 0.0;
        MPI_Reduce(&mine, &sum, 1, MPI_DOUBLE, MPI_SUM, 0, communicator);
        MPI_Reduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, 0, communicator);
        const double mean = sum / ranks;
        if (rank == 0)
            out << "    " << std::left << std::setw(28) << name << std::right << std::fixed << std::setprecision(2)
                << std::setw(11) << mean << std::setw(11) << largest << std::setw(13) << std::setprecision(5)
                << (steps > 0 ? mean / double(steps) : 0.0) << std::setw(9) << std::setprecision(1)
                << (total > 0 ? 100.0 * mean / total : 0.0) << " %\n";
    };
    if (rank == 0)
        out << "Timing (" << ranks << (ranks == 1 ? " rank, " : " ranks, ") << steps
            << " steps)            mean [s]    max [s]   s a step    share\n";
    double named = 0.0;
    for (const Phase& phase : phase_)
    {
        if (phase.name.find(": ") != std::string::npos) continue;
        named += phase.seconds;
        line(phase.name, phase.seconds);
        for (const Phase& part : phase_)
            if (part.name.compare(0, phase.name.size() + 2, phase.name + ": ") == 0)
                line("  " + part.name.substr(phase.name.size() + 2), part.seconds);
    }
    line("everything else", total - named);
    line("whole run", total);
    out.unsetf(std::ios::floatfield);
}

} // namespace hotbed
