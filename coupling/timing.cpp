#include "timing.hpp"

#include <iomanip>
#include <ostream>

namespace hotbed
{

double& Timing::seconds(const std::string& phase)
{
    for (auto& entry : phase_)
        if (entry.first == phase) return entry.second;
    phase_.emplace_back(phase, 0.0);
    return phase_.back().second;
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
    for (const auto& phase : phase_)
    {
        if (phase.first.find(": ") != std::string::npos) continue;
        named += phase.second;
        line(phase.first, phase.second);
        for (const auto& part : phase_)
            if (part.first.compare(0, phase.first.size() + 2, phase.first + ": ") == 0)
                line("  " + part.first.substr(phase.first.size() + 2), part.second);
    }
    line("everything else", total - named);
    line("whole run", total);
    out.unsetf(std::ios::floatfield);
}

} // namespace hotbed
