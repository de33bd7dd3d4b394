#pragma once

#include "gas.hpp"

#include "dem.hpp"

namespace hotbed
{

/// Ends a run in good order: on a signal with a restart, and where gas or particles blow up with an error that names
/// the place. One in a program.
class Watch
{
public:
    /// From now on a floating point exception ends the run with an error that says what was wrong with gas and
    /// particles, where there is a Watch.
    static void trapFloatingPoint();

    /// From now on SIGINT, SIGTERM and SIGUSR2 only ask for the end of the run; a second one kills.
    Watch(const Foam::fvMesh& mesh, const Gas& gas, const Dem& dem);
    ~Watch();

    /// Collective. @return the signal that any rank has had, the same on all; 0 without one
    int signal() const;

    /// Collective: ends the run where a field of the gas is not finite, or temperature or density not above zero; the
    /// error names cell and field.
    void gas() const;

    /// This rank's worst of gas and particles, in words.
    std::string worst() const;

private:
    std::string badCell() const;

    const Foam::fvMesh& mesh_;
    const Gas& gas_;
    const Dem& dem_;
};

} // namespace hotbed
