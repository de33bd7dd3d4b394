#pragma once

#include "fvCFD.H"
#include "fluidThermo.H"
#include "turbulentFluidThermoModel.H"
#include "pimpleControl.H"

#include "timing.hpp"

namespace hotbed
{

/// What the particles do to the gas in one step, by cell. Owned by the gas, filled by the coupling.
struct Exchange
{
    Foam::scalarField drag;       ///< sum w B: implicit drag coefficient [kg/s]
    Foam::vectorField dragSource; ///< explicit part of the drag on the gas [N]
    /// volume of the particles whose part of the pressure gradient the drag passes on to the gas within the step [m3]
    Foam::scalarField passedOn;
    Foam::scalarField conductance; ///< implicit heat exchange coefficient [W/K]
    Foam::scalar reference = 0;    ///< temperature from which on heatSource counts [K]
    Foam::scalarField heatSource;  ///< heat given by the particles to gas at the reference temperature [W]
};

/// The gas: volume-averaged compressible Navier-Stokes with voidage (eq 1-3, 7), on OpenFOAM's thermophysical and
/// turbulence libraries. Velocity U is the interstitial one; phi is the mass flux voidage * rho * U.
class Gas
{
public:
    /// @param energy whether the energy equation is solved
    Gas(Foam::fvMesh& mesh, bool energy, Timing& timing);

    Foam::volScalarField& voidage() { return voidage_; }
    const Foam::volVectorField& U() const { return U_; }
    const Foam::vector& gravity() const { return g_.value(); } ///< [m/s2]
    const Foam::scalarField& mass() const { return mass_; }    ///< voidage * rho [kg/m3]
    const Foam::volScalarField& T() const { return thermo_->T(); }
    const Foam::fluidThermo& thermo() const { return *thermo_; }
    const Foam::volVectorField& pressureGradient() const { return *pressureGradient_; }
    Exchange& exchange() { return exchange_; }

    /// Makes the start consistent with a voidage that was set after construction.
    /// @param resumed  fields were read from a restart: they are consistent
    void initialise(bool resumed);

    /// One time step: momentum, pressure, energy.
    void advance();

    /// Temperature of each cell as the exchange of the last step saw it [K]: the end of the step, with the heat
    /// capacity at its start (the same as T() where that is constant).
    const Foam::scalarField& exchangeTemperature() const { return exchangeTemperature_; }

    /// Mean pressure of the patches through which more gas enters than leaves, less that of the others [Pa]; 0 without
    /// both.
    Foam::scalar pressureDrop() const;
    Foam::scalar inflow() const;        ///< of the patches through which more gas enters than leaves [m3/s]
    Foam::scalar courantRate() const;   ///< largest Courant number over the time step, all cells and ranks [1/s]
    Foam::scalar energyContent() const; ///< sum voidage rho h V over all ranks [J]
    Foam::scalar energyInflow() const { return energyInflow_; } ///< enthalpy that entered in the last step [J]
    Foam::vector momentumContent() const;                       ///< sum voidage rho U V over all ranks [N s]
    /// Impulse that boundary (convection, pressure, stress) and gravity gave the bed in the last step, as far as the
    /// gas feels it: with the pressure gradient on the particles' share of the volume, without gravity on them [N s].
    Foam::vector momentumInflow() const;

private:
    void momentum();
    void pressure();
    void energy();
    void continuity();
    Foam::tmp<Foam::volScalarField> diffusivity() const;

    Foam::fvMesh& mesh_;
    bool energyOn_;
    const bool oblique_; ///< lines between cell centres are not at right angles to the faces
    Timing& timing_;
    Foam::pimpleControl pimple_;
    Foam::autoPtr<Foam::fluidThermo> thermo_;
    Foam::volScalarField& p_;
    Foam::volScalarField voidage_;
    Foam::volScalarField rho_;
    Foam::volScalarField
        pressureShare_; ///< of the pressure gradient, that drives the gas: voidage and what is passed on
    Foam::volVectorField U_;
    Foam::volScalarField mass_; ///< voidage * rho, consistent with phi to round-off
    Foam::surfaceScalarField phi_;
    Foam::autoPtr<Foam::compressible::turbulenceModel> turbulence_;
    Foam::uniformDimensionedVectorField g_;
    Foam::label pressureCell_ = 0;
    Foam::scalar pressureValue_ = 0;

    Exchange exchange_;
    Foam::tmp<Foam::fvVectorMatrix> UEqn_;
    // of the momentum equation, the same for all its pressure corrections
    Foam::autoPtr<Foam::volScalarField> rAU_;            ///< 1/A [m3 s/kg]
    Foam::autoPtr<Foam::surfaceScalarField> yield_;      ///< what a pressure gradient moves: pressureShare/A
    Foam::autoPtr<Foam::surfaceScalarField> fluxMemory_; ///< from the last step's flux being not that of its U [m3/s]
    Foam::autoPtr<Foam::volVectorField> pressureGradient_;
    Foam::autoPtr<Foam::volScalarField> viscosity_;        ///< voidage * mu, with turbulence [Pa s]
    Foam::vector transposedStress_;                        ///< force on this rank's boundary by mu dev2(grad U^T) [N]
    Foam::autoPtr<Foam::surfaceScalarField> enthalpyFlux_; ///< phi h at the end of the step before
    Foam::scalarField exchangeTemperature_;
    Foam::scalar energyInflow_ = 0;
};

} // namespace hotbed
