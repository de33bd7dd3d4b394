#include "settings.hpp"

#include "closures.hpp"

#include "IFstream.H"
#include "OSspecific.H"
#include "OStringStream.H"

#include <cmath>

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

/// one of the known laws, or an error that lists them
word choice(const dictionary& dict, const word& key, const wordList& known)
{
    const word value = dict.get<word>(key);
    if (!known.found(value))
        FatalIOErrorInFunction(dict) << "unknown " << key << " '" << value << "'; choose one of " << flatOutput(known)
                                     << exit(FatalIOError);
    return value;
}

scalar positive(const dictionary& dict, const word& key)
{
    const scalar value = dict.get<scalar>(key);
    if (!std::isfinite(value) || !(value > 0))
        FatalIOErrorInFunction(dict) << key << " must be a number > 0, not " << value << exit(FatalIOError);
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

    const wordList known = words({"demScript", "drag", "heatTransfer", "kernel", "kernelWidth", "windowLength",
                                  "kernelSamples", "exchange", "temperatureGradient", "writeRestart", "bedInterval"});
    for (const word& key : dict.toc())
        if (key != "FoamFile" && !known.found(key))
            FatalIOErrorInFunction(dict) << "unknown key '" << key << "'; known keys are " << flatOutput(known)
                                         << exit(FatalIOError);

    demScript = dict.get<fileName>("demScript");
    const HashTable<DragLaw> drags({{"Beetstra", beetstra}, {"ErgunWenYu", ergunWenYu}, {"none", nullptr}});
    dragName = choice(dict, "drag", drags.sortedToc());
    drag = drags[dragName];
    heatTransfer = choice(dict, "heatTransfer", words({"Gunn", "none"})) != "none";
    choice(dict, "kernel", words({"Deen"}));
    if (dict.found("kernelWidth") && dict.found("windowLength"))
        FatalIOErrorInFunction(dict) << "kernelWidth and windowLength are both given: keep one of the two"
                                     << exit(FatalIOError);
    if (dict.found("windowLength"))
    {
        windowLength = positive(dict, "windowLength");
        kernelWidth = 0;
    }
    else if (dict.found("kernelWidth"))
        kernelWidth = positive(dict, "kernelWidth");
    if (dict.found("kernelSamples"))
    {
        kernelSamples = dict.get<label>("kernelSamples");
        if (kernelSamples < 1 || kernelSamples > 16)
            FatalIOErrorInFunction(dict) << "kernelSamples must be from 1 to 16, not " << kernelSamples
                                         << exit(FatalIOError);
    }
    bedInterval = dict.lookupOrDefault<label>("bedInterval", 10);
    if (bedInterval < 1)
        FatalIOErrorInFunction(dict) << "bedInterval must be a whole number of gas steps, at least 1, not "
                                     << bedInterval << exit(FatalIOError);
    writeRestart = dict.lookupOrDefault<Switch>("writeRestart", true);
    if (dict.found("exchange")) linearExchange = choice(dict, "exchange", words({"linear", "implicit"})) == "linear";
    temperatureGradient = dict.lookupOrDefault<Switch>("temperatureGradient", true);
}

} // namespace hotbed
