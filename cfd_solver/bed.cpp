#include "bed.hpp"

#include "OSspecific.H"

#include <iomanip>

using namespace Foam;

namespace hotbed
{

Bed::Bed(const Time& runTime, const Coupling& coupling, const Dem& dem, const Gas& gas)
    : runTime_(runTime), coupling_(coupling), dem_(dem), gas_(gas)
{
    if (coupling_.heat())
    {
        gasEnergyAtStart_ = gasEnergy_ = gas_.energyContent();
        particleEnergyAtStart_ = particleEnergy_ = particleEnergy();
    }
    gasMomentumAtStart_ = gasMomentum_ = gas_.momentumContent();
    if (!Pstream::master()) return;
    const fileName folder = runTime_.globalPath() / "postProcessing" / "hotbed" / runTime_.timeName();
    mkDir(folder);
    csv_.open(folder / "bed.csv");
    csv_ << "time_s,particles,pressure_drop_Pa,mismatch";
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

double Bed::particleEnergy() const
{
    double sum = 0;
    for (int i = 0; i < dem_.size(); ++i) sum += dem_.heatCapacity(i) * dem_.temperature()[i];
    reduce(sum, sumOp<double>());
    return sum;
}

void Bed::particlesWillMove()
{
    if (coupling_.heat() && dem_.moving()) energyBeforeMove_ = particleEnergy();
}

void Bed::record()
{
    const label particles = returnReduce(label(dem_.size()), sumOp<label>());
    const scalar pressureDrop = gas_.pressureDrop();
    if (csv_.is_open())
        csv_ << runTime_.value() << ',' << particles << ',' << pressureDrop << ',' << coupling_.mismatch();
    mismatch_ = std::max(mismatch_, coupling_.mismatch());
    if (coupling_.heat())
    {
        double sum = 0, low = GREAT, high = -GREAT, nusselt = 0;
        label exchanging = 0; // particles that have a Nusselt number
        for (int i = 0; i < dem_.size(); ++i)
        {
            const double T = dem_.temperature()[i];
            sum += T;
            low = std::min(low, T);
            high = std::max(high, T);
            nusselt += dem_.nusselt()[i];
            exchanging += dem_.nusselt()[i] > 0;
        }
        reduce(sum, sumOp<double>());
        reduce(nusselt, sumOp<double>());
        reduce(exchanging, sumOp<label>());
        reduce(low, minOp<double>());
        reduce(high, maxOp<double>());
        gasEnergy_ = gas_.energyContent();
        particleEnergy_ = particleEnergy();
        if (dem_.moving()) carried_ += particleEnergy_ - energyBeforeMove_;
        inflow_ += gas_.energyInflow();
        exchanged_ += coupling_.heatExchanged();
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
        impulseIn_ += gas_.momentumInflow();
        impulse_ += coupling_.impulse();
        impulseExchanged_ += mag(coupling_.impulse());
        if (csv_.is_open())
            csv_ << ',' << impulse_.x() << ',' << impulse_.y() << ',' << impulse_.z() << ',' << impulseExchanged_ << ','
                 << momentumError();
    }
    if (csv_.is_open()) csv_ << '\n';
}

double Bed::momentumError() const
{
    const double error = mag(gasMomentum_ - gasMomentumAtStart_ + impulse_ - impulseIn_);
    return impulseExchanged_ > 0 ? error / impulseExchanged_ : 0.0;
}

void Bed::report(Ostream& out) const
{
    out << "Taken from one phase less given to the other, largest of all steps    " << mismatch_ << nl;
    if (coupling_.push())
        out << "Momentum budget: not accounted for " << momentumError() << " of the impulse given to the particles"
            << nl;
    if (!coupling_.heat()) return;
    const double gas = gasEnergy_ - gasEnergyAtStart_, particles = particleEnergy_ - particleEnergyAtStart_;
    const double rest = gas + particles - inflow_ - carried_;
    out << "Energy budget [J]" << nl << "    gained by the gas           " << gas << nl
        << "    gained by the particles     " << particles << nl << "    came in with the gas        " << inflow_ << nl
        << "    came in with particles      " << carried_ << nl << "    exchanged gas-particles     " << exchanged_
        << nl << "    not accounted for           " << rest << " = " << (exchanged_ > 0 ? rest / exchanged_ : 0.0)
        << " of the exchange" << nl;
}

} // namespace hotbed
