#include "restart.hpp"

#include "whole_file.hpp"

#include "IFstream.H"
#include "OSspecific.H"
#include "OStringStream.H"

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include <sys/statvfs.h>

using namespace Foam;

namespace hotbed
{
namespace
{

const word particleFile("particles.liggghts");

/// SHA-1 of a file, or of nothing where it cannot be read. @param end  its last bytes, for OpenFOAM's closing line
std::string checksum(const std::string& path, std::string& end)
{
    std::ifstream file(path, std::ios::binary);
    SHA1 sum;
    std::vector<char> bytes(1 << 16);
    end.clear();
    do
    {
        file.read(bytes.data(), std::streamsize(bytes.size()));
        const std::size_t size = std::size_t(file.gcount());
        sum.append(bytes.data(), size);
        end = (end + std::string(bytes.data() + size - std::min<std::size_t>(size, 100), bytes.data() + size));
        if (end.size() > 100) end.erase(0, end.size() - 100);
    } while (file);
    return sum.digest().str();
}

/// Whether OpenFOAM came to the end of a file that it wrote, which it closes with a line of stars.
bool closed(const fileName& path, std::string end)
{
    if (path.hasExt("gz"))
    {
        IFstream file(path.lessExt()); // unpacks
        end.assign(std::istreambuf_iterator<char>(file.stdStream()), {});
        end.erase(0, end.size() - std::min<std::size_t>(end.size(), 100));
    }
    return end.find("*********** //") != std::string::npos;
}

[[noreturn]] void cannotWriteFields(const Time& runTime, const fileName& path)
{
    struct statvfs disk;
    const bool full = statvfs(path.path().c_str(), &disk) == 0 && disk.f_bavail * disk.f_frsize < 65536;
    rmDir(runTime.timePath());
    cannotWrite(path, full ? ENOSPC : EIO);
}

/// Checksums of the files that OpenFOAM wrote of this rank's fields at the present time, a line each.
std::string fieldChecksums(const Time& runTime)
{
    std::ostringstream lines;
    fileNameList files = readDir(runTime.timePath(), fileName::FILE, false);
    files.append("uniform/time");
    for (const fileName& name : files)
    {
        const fileName path = runTime.timePath() / name;
        std::string end;
        const std::string sum = checksum(path, end);
        if (!closed(path, end)) cannotWriteFields(runTime, path);
        lines << sum << "  " << path.relative(runTime.globalPath()).c_str() << '\n';
    }
    return lines.str();
}

/// The time that a folder is named after, negative where that is something else.
scalar timeOf(const fileName& folder)
{
    char* end = nullptr;
    const scalar time = std::strtod(folder.c_str(), &end);
    return end != folder.c_str() && *end == '\0' && std::isfinite(time) ? time : -1;
}

/// the subdomain folder a path begins with, empty without one
std::string subdomain(const std::string& path)
{
    return path.compare(0, 9, "processor") == 0 ? path.substr(0, path.find('/')) : std::string();
}

} // namespace

void writeFields(Time& runTime, bool now)
{
    const bool throwing = FatalIOError.throwExceptions();
    try
    {
        if (now)
            runTime.writeAndEnd();
        else
            runTime.write();
    }
    catch (const IOerror& problem)
    {
        FatalIOError.dontThrowExceptions();
        cannotWriteFields(runTime, problem.ioFileName());
    }
    if (!throwing) FatalIOError.dontThrowExceptions();
}

void Restart::setAsideUnfinished(const fileName& casePath)
{
    const fileName restarts = casePath / "restart";
    if (!isDir(restarts)) return;
    if (Pstream::master())
    {
        scalar last = 0;
        for (const fileName& time : readDir(restarts, fileName::DIRECTORY))
            if (isFile(restarts / time / "state")) last = max(last, timeOf(time));
        fileNameList places(1, casePath);
        for (const fileName& place : readDir(casePath, fileName::DIRECTORY))
            if (place.find("processor") == 0) places.append(casePath / place);
        for (const fileName& place : places)
            for (const fileName& time : readDir(place, fileName::DIRECTORY))
            {
                if (!(timeOf(time) > last * (1 + 1e-9))) continue;
                const fileName aside = place / (time + ".unfinished");
                rmDir(aside);
                mv(place / time, aside);
                Info << "Restart: " << place / time << " was left unfinished, set aside as " << aside.name() << nl;
            }
    }
    returnReduce(label(0), sumOp<label>()); // nobody reads times before that is done
}

Restart::Restart(const Time& runTime) : runTime_(runTime)
{
    if (!(runTime_.value() > 0)) return;
    start_ = runTime_.globalPath() / "restart" / runTime_.timeName();
    if (!isFile(start_ / "state"))
        FatalErrorInFunction << "the run would start at " << runTime_.timeName() << " s, but " << start_
                             << " holds no complete restart: set startFrom startTime and startTime 0 in "
                             << "system/controlDict, or a time that has one" << exit(FatalError);
    refuseDamaged();
    IFstream file(start_ / "state");
    state_ = dictionary(file);
    state_.name() = start_ / "state"; // for errors
    resumed_ = true;
}

/// What another decomposition wrote is not compared: reconstructPar and decomposePar made this one's fields from it.
void Restart::refuseDamaged() const
{
    const fileName list = start_ / "checksums";
    string damaged;
    if (Pstream::master() && isFile(list))
    {
        std::stringstream file;
        file << std::ifstream(list).rdbuf();
        const std::string ends = "/state\n"; // its last entry
        const std::string text = file.str();
        const bool whole = text.size() > ends.size() && text.compare(text.size() - ends.size(), ends.size(), ends) == 0;
        std::vector<std::pair<std::string, std::string>> entries;
        std::set<std::string> subdomains;
        for (std::string sum, path; file >> sum && std::getline(file >> std::ws, path);)
        {
            entries.emplace_back(sum, path);
            if (path.compare(0, 8, "restart/") != 0) subdomains.insert(subdomain(path));
        }
        const bool sameRanks = Pstream::parRun() ? int(subdomains.size()) == Pstream::nProcs() && !subdomains.count("")
                                                 : subdomains.count("") == subdomains.size();
        std::string end;
        for (const auto& [sum, path] : entries)
        {
            if (!sameRanks && path.compare(0, 8, "restart/") != 0) continue;
            const std::string place = runTime_.globalPath() + "/" + path; // OpenFOAM ends a run at a name with a blank
            if (damaged.empty() && checksum(place, end) != sum)
                damaged = path + (std::ifstream(place) ? " is not as the run wrote it" : " is missing");
        }
        if (damaged.empty() && !whole) damaged = list.relative(runTime_.globalPath()) + " is not as the run wrote it";
    }
    Pstream::scatter(damaged);
    if (!damaged.empty())
        FatalErrorInFunction << "the restart of " << runTime_.timeName() << " s in " << runTime_.globalPath()
                             << " is damaged: " << damaged.c_str()
                             << ". To go on from the restart before it, remove restart/" << runTime_.timeName()
                             << "/state. If you changed the file yourself and mean it, remove restart/"
                             << runTime_.timeName() << "/checksums" << exit(FatalError);
}

fileName Restart::particles() const
{
    return resumed_ ? start_ / particleFile : fileName("none");
}

void Restart::compare(const Dem& dem, const fileName& script) const
{
    if (!resumed_) return;
    if (dem.step() != state_.get<label>("demStep"))
        FatalErrorInFunction << script << " did not go on from the restart: where the variable resume is 1, it must "
                             << "say 'read_restart ${restart}' instead of making a box and particles"
                             << exit(FatalError);
    const label particles = returnReduce(label(dem.size()), sumOp<label>());
    const label written = state_.lookupOrDefault<label>("particles", particles);
    if (particles != written)
        FatalErrorInFunction << start_ / particleFile << " gave " << particles << " particles, but the run had "
                             << written << ": it belongs to another run, or " << script << " makes or removes some "
                             << "where the variable resume is 1" << exit(FatalError);
}

void Restart::begin() const
{
    const fileName place = runTime_.globalPath() / "restart";
    if (Pstream::master() && !mkDir(place)) cannotWrite(place, errno);
}

fileName Restart::folder() const
{
    return runTime_.globalPath() / "restart" / runTime_.timeName();
}

void Restart::open() const
{
    if (!Pstream::master()) return;
    mkDir(folder());
    rm(folder() / "state"); // of an earlier run: what it stands for is overwritten now
}

void Restart::writeParticles(Dem& dem)
{
    std::unique_ptr<WholeFile> file;
    if (Pstream::master()) file = std::make_unique<WholeFile>(folder() / particleFile);
    dem.writeRestart([&file](const char* bytes, std::size_t size) { file->write(bytes, size); });
    if (file) particleSum_ = file->close();
}

void Restart::complete(dictionary state, const Dem& dem)
{
    state.add("demStep", label(dem.step()));
    state.add("particles", returnReduce(label(dem.size()), sumOp<label>()));
    List<string> sums(Pstream::nProcs());
    sums[Pstream::myProcNo()] = fieldChecksums(runTime_);
    Pstream::gatherList(sums);
    if (!Pstream::master()) return;

    OStringStream text;
    text.precision(17);
    text << state;
    SHA1 sum;
    sum.append(text.str());
    const fileName place = "restart" / fileName(runTime_.timeName());
    WholeFile checksums(folder() / "checksums");
    std::ostringstream lines;
    lines << particleSum_ << "  " << (place / particleFile).c_str() << '\n';
    for (const string& ofRank : sums) lines << ofRank.c_str();
    lines << sum.digest().str() << "  " << (place / "state").c_str() << '\n';
    checksums.write(lines.str().data(), lines.str().size());
    checksums.close();
    WholeFile last(folder() / "state");
    last.write(text.str().data(), text.str().size());
    last.close();
    purge();
}

void Restart::purge() const
{
    if (runTime_.controlDict().lookupOrDefault<label>("purgeWrite", 0) == 0) return;
    const fileName restarts = runTime_.globalPath() / "restart";
    for (const fileName& time : readDir(restarts, fileName::DIRECTORY))
        if (!isDir(runTime_.path() / time)) rmDir(restarts / time);
}

} // namespace hotbed
