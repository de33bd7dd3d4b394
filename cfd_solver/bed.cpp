#include "bed.hpp"

#include "whole_file.hpp"

#include "OSspecific.H"

#include <algorithm>
#include <cerrno>
#include <iomanip>
#include <numeric>

using namespace Foam;

namespace hotbed
{

Column::Column(const fvMesh& mesh)
{
    const vector g = mesh.lookupObject<uniformDimensionedVectorField>("g").value();
    gravity = mag(g);
    up = gravity > 0 ? vector(-g / gravity) : vector(0, 0, 1);
    const scalarField along(mesh.points() & up);
    low = gMin(along);
    height = gMax(along) - low;
    section = gSum(mesh.V()) / height;
}

Bed::Bed(const fvMesh& mesh, const Coupling& coupling, const Dem& dem, const Gas& gas, int interval)
    : runTime_(mesh.time()), coupling_(coupling), dem_(dem), gas_(gas), interval_(interval), column_(mesh)
{
    if (coupling_.heat())
    {
        gasEnergyAtStart_ = gasEnergy_ = gas_.energyContent();
        particleEnergyAtStart_ = particleEnergy_ = dem_.thermalEnergy();
    }
    gasMomentumAtStart_ = gasMomentum_ = gas_.momentumContent();
    if (dem_.moving()) largestOverlap();
    if (!Pstream::master()) return;
    const fileName folder = runTime_.globalPath() / "postProcessing" / "hotbed" / runTime_.timeName();
    mkDir(folder);
    csvPath_ = folder / "bed.csv";
    csv_.open(csvPath_);
    if (!csv_) cannotWrite(csvPath_, errno);
    csv_ << "time_s,particles,pressure_drop_Pa,mismatch";
    if (dem_.moving()) csv_ << ",z_mean_m,height_m,weight_Pa,overlap_max";
    if (coupling_.heat())
        csv_ << ",T_mean_K,T_min_K,T_max_K,Nu_mean,gas_T_min_K,gas_T_max_K,gas_energy_J,particle_energy_J,inflow_J,"
                "carried_J,exchanged_J,budget_error";
    if (coupling_.push()) csv_ << ",impulse_x_Ns,impulse_y_Ns,impulse_z_Ns,impulse_exchanged_Ns,momentum_error";
    csv_ << '\n' << std::setprecision(17);
}

dictionary Bed::state() const
{
    dictionary state;
    state.add("gasEnergyAtStart", gasEnergyAtStart_);
    state.add("particleEnergyAtStart", particleEnergyAtStart_);
    state.add("inflow", inflow_);
    state.add("carried", carried_);
    state.add("exchanged", exchanged_);
    state.add("gasMomentumAtStart", gasMomentumAtStart_);
    state.add("impulseIn", impulseIn_);
    state.add("impulse", impulse_);
    state.add("impulseExchanged", impulseExchanged_);
    state.add("mismatch", mismatch_);
    return state;
}

void Bed::resume(const dictionary& state)
{
    gasEnergyAtStart_ = state.get<scalar>("gasEnergyAtStart");
    particleEnergyAtStart_ = state.get<scalar>("particleEnergyAtStart");
    inflow_ = state.get<scalar>("inflow");
    carried_ = state.get<scalar>("carried");
    exchanged_ = state.get<scalar>("exchanged");
    gasMomentumAtStart_ = state.get<vector>("gasMomentumAtStart");
    impulseIn_ = state.get<vector>("impulseIn");
    impulse_ = state.get<vector>("impulse");
    impulseExchanged_ = state.get<scalar>("impulseExchanged");
    mismatch_ = state.get<scalar>("mismatch");
}

void Bed::particlesWillMove()
{
    if (coupling_.heat() && dem_.moving()) energyBeforeMove_ = dem_.thermalEnergy();
}

void Bed::particlesHaveMoved()
{
    if (coupling_.heat() && dem_.moving()) carried_ += dem_.thermalEnergy() - energyBeforeMove_;
}

void Bed::record(bool last)
{
    if (coupling_.heat())
    {
        inflow_ += gas_.energyInflow();
        exchanged_ += coupling_.heatExchanged();
    }
    if (coupling_.push())
    {
        impulseIn_ += gas_.momentumInflow();
        impulse_ += coupling_.impulse();
        impulseExchanged_ += mag(coupling_.impulse());
    }
    mismatch_ = std::max(mismatch_, coupling_.mismatch());
    // the last one now: writing a restart puts the particles in another order, sums differ in the last digit
    recorded_ = runTime_.timeIndex() % interval_ == 0 || last;
    if (recorded_) line();
}

void Bed::heights(double& mean, double& height) const
{
    // particle volume by layers of the mesh's extent: each rank sums its own, all ranks add them up
    constexpr int layers = 1000;
    List<double> volume(layers + 1, 0.0); // the last entry: volume times height
    for (int i = 0; i < dem_.size(); ++i)
    {
        const double* x = dem_.position()[i];
        const double z = (vector(x[0], x[1], x[2]) & column_.up) - column_.low;
        const double ball = std::pow(dem_.radius()[i], 3);
        volume[std::clamp(int(z / column_.height * layers), 0, layers - 1)] += ball;
        volume[layers] += ball * z;
    }
    Pstream::listCombineGather(volume, plusEqOp<double>());
    if (!Pstream::master()) return;
    const double total = std::accumulate(volume.begin(), volume.begin() + layers, 0.0);
    mean = height = 0;
    if (!(total > 0)) return;
    mean = volume[layers] / total;
    double above = 0.01 * total; // what lies above the height
    int layer = layers - 1;
    while (volume[layer] < above) above -= volume[layer--];
    height = (layer + 1 - above / volume[layer]) * column_.height / layers;
}

double Bed::weight() const
{
    double mass = 0;
    for (int i = 0; i < dem_.size(); ++i) mass += dem_.mass()[i];
    return returnReduce(mass, sumOp<double>()) * column_.gravity / column_.section;
}

double Bed::largestOverlap() const
{
    int particle = -1;
    const double overlap = dem_.largestOverlap(&particle);
    if (overlap > 0.3)
        FatalErrorInFunction << dem_.describe(particle).c_str() << " overlaps what it touches by " << overlap
                             << " of the smaller one's diameter. Likely particles were made or "
                             << "inserted on top of each other, the springs are too soft (kn), or the DEM step is too "
                             << "long (timestep). The restarts written before are whole" << exit(FatalError);
    return returnReduce(overlap, maxOp<double>());
}

void Bed::line()
{
    const label particles = returnReduce(label(dem_.size()), sumOp<label>());
    if (particles < particles_ && !warned_)
    {
        warned_ = true;
        WarningInFunction << particles_ - particles << " of " << particles_ << " particles are gone at "
                          << runTime_.timeName() << " s: they left LIGGGHTS' box or the DEM script removed them. Where "
                          << "that is not meant, look for a wall that is missing or too soft (kn); 'thermo_modify lost "
                          << "error' in the DEM script makes it an error. Said once" << endl;
    }
    particles_ = particles;
    const scalar pressureDrop = gas_.pressureDrop();
    if (csv_.is_open()) csv_ << runTime_.value() << ',' << particles << ',' << pressureDrop << ',' << mismatch_;
    if (dem_.moving())
    {
        double mean = 0, height = 0;
        heights(mean, height);
        const double weight = this->weight(), overlap = largestOverlap();
        if (csv_.is_open()) csv_ << ',' << mean << ',' << height << ',' << weight << ',' << overlap;
    }
    if (coupling_.heat())
    {
        double sum = 0, low = GREAT, high = -GREAT, nusselt = 0;
        label exchanging = 0; // particles that have a Nusselt number
        const double *T = dem_.temperature(), *Nu = dem_.nusselt();
        for (int i = 0; i < dem_.size(); ++i)
        {
            sum += T[i];
            low = std::min(low, T[i]);
            high = std::max(high, T[i]);
            nusselt += Nu[i];
            exchanging += Nu[i] > 0;
        }
        reduce(sum, sumOp<double>());
        reduce(nusselt, sumOp<double>());
        reduce(exchanging, sumOp<label>());
        reduce(low, minOp<double>());
        reduce(high, maxOp<double>());
        gasEnergy_ = gas_.energyContent();
        particleEnergy_ = dem_.thermalEnergy();
        const scalar gasLow = gMin(gas_.T().primitiveField()), gasHigh = gMax(gas_.T().primitiveField());
        const double change = gasEnergy_ - gasEnergyAtStart_ + particleEnergy_ - particleEnergyAtStart_;
        const double error = exchanged_ > 0 ? (change - inflow_ - carried_) / exchanged_ : 0.0;
        if (csv_.is_open())
        {
            // without particles there is nothing to take a mean of: the columns stay empty
            csv_ << ',';
            if (particles)
                csv_ << sum / particles << ',' << low << ',' << high << ',';
            else
                csv_ << ",,,";
            if (exchanging) csv_ << nusselt / exchanging;
            csv_ << ',' << gasLow << ',' << gasHigh << ',' << gasEnergy_ << ',' << particleEnergy_ << ',' << inflow_
                 << ',' << carried_ << ',' << exchanged_ << ',' << error;
        }
    }
    if (coupling_.push())
    {
        gasMomentum_ = gas_.momentumContent();
        if (csv_.is_open())
            csv_ << ',' << impulse_.x() << ',' << impulse_.y() << ',' << impulse_.z() << ',' << impulseExchanged_ << ','
                 << momentumError();
    }
    if (!csv_.is_open()) return;
    csv_ << std::endl; // to disk: what a killed run has computed is there
    if (!csv_) cannotWrite(csvPath_, errno);
}

double Bed::momentumError() const
{
    const double error = mag(gasMomentum_ - gasMomentumAtStart_ + impulse_ - impulseIn_);
    return impulseExchanged_ > 0 ? error / impulseExchanged_ : 0.0;
}

void Bed::finish(Ostream& out)
{
    if (!recorded_) line();
    recorded_ = true;
    out << "Taken from one phase less given to the other, largest of all steps    " << mismatch_ << nl;
    if (coupling_.push())
        out << "Momentum budget: not accounted for " << momentumError() << " of the impulse given to the particles"
            << nl;
    if (!coupling_.heat()) return;
    particleEnergy_ = dem_.thermalEnergy(); // a restart after the last line may have let particles go
    const double gas = gasEnergy_ - gasEnergyAtStart_, particles = particleEnergy_ - particleEnergyAtStart_;
    const double rest = gas + particles - inflow_ - carried_;
    out << "Energy budget [J]" << nl << "    gained by the gas           " << gas << nl
        << "    gained by the particles     " << particles << nl << "    came in with the gas        " << inflow_ << nl
        << "    came in with particles      " << carried_ << nl << "    exchanged gas-particles     " << exchanged_
        << nl << "    not accounted for           " << rest << " = " << (exchanged_ > 0 ? rest / exchanged_ : 0.0)
        << " of the exchange" << nl;
}

} // namespace hotbed
