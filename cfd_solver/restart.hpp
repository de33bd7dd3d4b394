#pragma once

#include "fvCFD.H"

#include "dem.hpp"

namespace hotbed
{

/// OpenFOAM's fields of the present time. Ends the run where they cannot be written whole; what is there is removed, to
/// make room for the log.
/// @param now  even if it is not time for it; the run ends
void writeFields(Foam::Time& runTime, bool now);

/// Restarts, one for each of OpenFOAM's write times, in restart/<time>/ beside the time folders: LIGGGHTS' restart
/// file, `checksums` of everything the restart is made of (as of `sha1sum`, paths from the case), and the dictionary
/// `state`, which appears only when everything else of that time is on disk. A time without it is not taken for a
/// restart.
class Restart
{
public:
    /// Before the time database is made: sets aside time folders that a killed run left unfinished (<time>.unfinished),
    /// so that `startFrom latestTime` finds the last complete one. Does nothing in a case without restarts.
    static void setAsideUnfinished(const Foam::fileName& casePath);

    /// @param runTime where the run starts; a start after 0 needs its restart, whole, else an error names file and mend
    explicit Restart(const Foam::Time& runTime);

    bool resumed() const { return resumed_; }

    /// LIGGGHTS' restart file of the start ("none" for a fresh one): the variable `restart` of the DEM script, where
    /// `resume` is 1.
    Foam::fileName particles() const;

    const Foam::dictionary& state() const { return state_; }

    /// Ends the run where the DEM script has not gone on with the particles of the restart.
    void compare(const Dem& dem, const Foam::fileName& script) const;

    /// Marks the case as one with restarts, from when on unfinished times are set aside.
    void begin() const;

    /// Before anything of the present time is written.
    void open() const;

    /// The particles of a restart of the present time.
    void writeParticles(Dem& dem);

    /// The last word: checks that the fields of this time are whole, then writes checksums and state, with particle and
    /// step numbers of the DEM in it.
    void complete(Foam::dictionary state, const Dem& dem);

private:
    Foam::fileName folder() const; ///< of the present time
    void refuseDamaged() const;
    void purge() const; ///< removes restarts whose fields purgeWrite has removed

    const Foam::Time& runTime_;
    bool resumed_ = false;
    Foam::fileName start_;
    Foam::dictionary state_;
    std::string particleSum_; ///< SHA-1 of the particle file just written, on the master
};

} // namespace hotbed
