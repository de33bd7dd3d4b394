#include "settings.hpp"

#include "closures.hpp"
#include "range.hpp"

#include "IFstream.H"
#include "OSspecific.H"
#include "OStringStream.H"

#include <cstdlib>

using namespace Foam;

namespace hotbed
{
namespace
{

wordList words(std::initializer_list<const char*> names)
{
    wordList list;
    for (const char* name : names) list.append(word(name));
    return list;
}

/// Ends with the key, what it may be and what it is.
[[noreturn]] void refuse(const dictionary& dict, const word& key, const std::string& allowed)
{
    OStringStream text;
    const entry* given = dict.findEntry(key, keyType::LITERAL);
    if (given && given->isStream())
        for (const token& part : given->stream()) text << (text.str().empty() ? "" : " ") << part;
    else if (given)
        text << "a dictionary";
    if (given)
        FatalIOErrorInFunction(dict) << key << " must be " << allowed.c_str() << ", not '" << text.str().c_str() << "'"
                                     << exit(FatalIOError);
    FatalIOErrorInFunction(dict) << key << " is missing: add '" << key << " ...;', " << allowed.c_str()
                                 << exit(FatalIOError);
    std::abort();
}

/// What `get` reads from an entry; where OpenFOAM cannot read it so, an error that says what is allowed.
template <class Get> auto read(const dictionary& dict, const word& key, const std::string& allowed, const Get& get)
{
    const bool before = FatalIOError.throwExceptions();
    try
    {
        const auto value = get();
        FatalIOError.throwExceptions(before);
        return value;
    }
    catch (const Foam::IOerror&)
    {
        FatalIOError.throwExceptions(before);
        refuse(dict, key, allowed);
    }
}

/// one of the known laws, or an error that lists them
word choice(const dictionary& dict, const word& key, const wordList& known)
{
    std::string allowed = "one of";
    for (const word& name : known) allowed += ' ' + name;
    const word value = read(dict, key, allowed, [&] { return dict.get<word>(key); });
    if (!known.found(value)) refuse(dict, key, allowed);
    return value;
}

/// one of the laws of closures.hpp, null for `none`. @param name  set to what the dictionary says
template <class Law>
Law law(const dictionary& dict, const word& key, const std::map<std::string, Law>& known, word& name)
{
    wordList names;
    for (const auto& entry : known) names.append(word(entry.first));
    names.append("none");
    name = choice(dict, key, names);
    return name == "none" ? nullptr : known.at(name);
}

/// @param unit  dimensions may be given too, and must be these then
scalar number(const dictionary& dict, const word& key, const Range& range, const dimensionSet& unit = dimless)
{
    OStringStream allowed;
    allowed << "a number " << range.text().c_str();
    if (!unit.dimensionless()) allowed << ' ' << unit;
    const scalar value = read(dict, key, allowed.str(), [&] { return dimensionedScalar(key, unit, dict).value(); });
    if (!range.holds(value)) refuse(dict, key, allowed.str());
    return value;
}

label wholeNumber(const dictionary& dict, const word& key, const Range& range)
{
    const std::string allowed = "a whole number " + range.text();
    const label value = read(dict, key, allowed, [&] { return dict.get<label>(key); });
    if (!range.holds(value)) refuse(dict, key, allowed);
    return value;
}

bool onOff(const dictionary& dict, const word& key, bool preset)
{
    const std::string allowed = "yes or no, on or off, true or false";
    if (!dict.found(key)) return preset;
    const Switch value(read(dict, key, allowed, [&] { return dict.get<word>(key); }), true);
    if (!value.valid()) refuse(dict, key, allowed);
    return value;
}

} // namespace

std::vector<std::pair<std::string, std::string>> readSettings(const Time& runTime)
{
    std::vector<std::pair<std::string, std::string>> settings;
    const fileName path = runTime.globalPath() / "settings";
    if (!isFile(path)) return settings;
    IFstream file(path);
    const dictionary dict(file);
    forAllConstIters(dict, entry)
    {
        if (entry().keyword() == "FoamFile" || !entry().isStream()) continue;
        const ITstream& stream = entry().stream();
        if (stream.size() != 1) continue;
        OStringStream text;
        text.precision(17);
        text << stream[0];
        settings.emplace_back(entry().keyword(), stream[0].isString() ? stream[0].stringToken() : text.str());
    }
    return settings;
}

CouplingSettings::CouplingSettings(const Time& runTime)
{
    const IOdictionary dict(
        IOobject("couplingProperties", runTime.constant(), runTime, IOobject::MUST_READ, IOobject::NO_WRITE, false));

    const wordList known =
        words({"demScript", "drag", "heatTransfer", "kernel", "kernelWidth", "windowLength", "kernelSamples",
               "closureCo", "exchange", "temperatureGradient", "writeRestart", "bedInterval"});
    for (const word& key : dict.toc())
        if (key != "FoamFile" && !known.found(key))
            FatalIOErrorInFunction(dict) << "unknown key '" << key << "'; known keys are " << flatOutput(known)
                                         << exit(FatalIOError);

    const char* const scriptIs = "the LIGGGHTS script, its path from the case in quotes";
    demScript = read(dict, "demScript", scriptIs, [&] { return dict.get<fileName>("demScript"); });
    if (!isFile(demScript))
        FatalIOErrorInFunction(dict) << "cannot read the DEM script '" << demScript.c_str() << "': demScript must be "
                                     << scriptIs << exit(FatalIOError);
    drag = law(dict, "drag", dragLaws(), dragName);
    heatTransfer = law(dict, "heatTransfer", heatLaws(), heatName);
    choice(dict, "kernel", words({"Deen"}));
    if (dict.found("kernelWidth") && dict.found("windowLength"))
        FatalIOErrorInFunction(dict) << "kernelWidth and windowLength are both given: keep one of the two"
                                     << exit(FatalIOError);
    if (dict.found("windowLength"))
    {
        windowLength = number(dict, "windowLength", {0.0, false, 1e4}, dimLength);
        kernelWidth = 0;
    }
    else if (dict.found("kernelWidth"))
        kernelWidth = number(dict, "kernelWidth", {0.0, false, 1e6});
    if (dict.found("kernelSamples")) kernelSamples = wholeNumber(dict, "kernelSamples", {1, true, 16});
    if (dict.found("closureCo")) closureCo = number(dict, "closureCo", {0.0, true, 1.0});
    if (dict.found("bedInterval")) bedInterval = wholeNumber(dict, "bedInterval", {1, true});
    writeRestart = onOff(dict, "writeRestart", true);
    if (dict.found("exchange")) linearExchange = choice(dict, "exchange", words({"linear", "implicit"})) == "linear";
    temperatureGradient = onOff(dict, "temperatureGradient", true);

    const dictionary& control = runTime.controlDict();
    if (writeRestart && control.found("purgeWrite") && wholeNumber(control, "purgeWrite", {0, true}) == 1)
        FatalIOErrorInFunction(control) << "purgeWrite 1 removes the last whole restart's fields before "
                                           "the new one is whole: set it to 2 or more, or "
                                        << "to 0 to keep all" << exit(FatalIOError);
}

std::array<int, 3> piecesOfParticles(const Time& runTime)
{
    const IOdictionary dict(
        IOobject("decomposeParDict", runTime.system(), runTime, IOobject::READ_IF_PRESENT, IOobject::NO_WRITE, false));
    const word method = dict.lookupOrDefault<word>("method", "none");
    if (method == "simple" || method == "hierarchical")
    {
        const dictionary& coeffs = dict.optionalSubDict("coeffs").optionalSubDict(method + "Coeffs");
        const Vector<label> n = coeffs.lookupOrDefault("n", Vector<label>(Zero));
        if (n.x() * n.y() * n.z() == Pstream::nProcs()) return {n.x(), n.y(), n.z()};
    }
    std::array<int, 3> pieces = {0, 0, 0};
    const vector g = uniformDimensionedVectorField(
                         IOobject("g", runTime.constant(), runTime, IOobject::MUST_READ, IOobject::NO_WRITE, false))
                         .value();
    if (mag(g) > 0) pieces[findMax(FixedList<scalar, 3>{mag(g.x()), mag(g.y()), mag(g.z())})] = 1;
    return pieces;
}

StepSettings::StepSettings(const Time& runTime)
{
    const dictionary& control = runTime.controlDict();
    adjust = onOff(control, "adjustTimeStep", false);
    for (const char* key : {"maxCo", "maxDeltaT"})
        if (control.found(key) && !control.found("adjustTimeStep"))
            FatalIOErrorInFunction(control) << "adjustTimeStep is missing, but " << key
                                            << " is given: add 'adjustTimeStep yes;', or no" << exit(FatalIOError);
    if (!adjust) return;
    maxCo = number(control, "maxCo", {0.0, false});
    maxDeltaT = number(control, "maxDeltaT", {0.0, false}, dimTime);
}

} // namespace hotbed
