#pragma once

#include "fvCFD.H"

namespace hotbed
{

/// Restarts, one for each of OpenFOAM's write times, in restart/<time>/ beside the time folders: LIGGGHTS' restart file
/// and the dictionary `state`, which is written last and appears only when everything else of that time is on disk. A
/// time without it is not taken for a restart.
class Restart
{
public:
    /// Before the time database is made: sets aside time folders that a killed run left unfinished (<time>.unfinished),
    /// so that `startFrom latestTime` finds the last complete one. Does nothing in a case without restarts.
    static void setAsideUnfinished(const Foam::fileName& casePath);

    /// @param runTime where the run starts; a start after 0 needs its restart, else an error names the mend
    explicit Restart(const Foam::Time& runTime);

    bool resumed() const { return resumed_; }

    /// LIGGGHTS' restart file of the start ("none" for a fresh one): the variable `restart` of the DEM script, where
    /// `resume` is 1.
    Foam::fileName particles() const;

    const Foam::dictionary& state() const { return state_; }

    /// Marks the case as one with restarts, from when on unfinished times are set aside.
    void begin() const;

    /// Folder for a restart of the present time, made where it is missing.
    Foam::fileName folder() const;

    /// The last word: this restart is complete.
    void complete(const Foam::dictionary& state) const;

private:
    const Foam::Time& runTime_;
    bool resumed_ = false;
    Foam::fileName start_;
    Foam::dictionary state_;
};

} // namespace hotbed
