#pragma once

#include "gas.hpp"
#include "settings.hpp"

#include "cell_values.hpp"
#include "dem.hpp"
#include "mapping.hpp"
#include "timing.hpp"

#include <cmath>

namespace hotbed
{

inline double sphereVolume(double radius)
{
    return 4.0 / 3.0 * M_PI * radius * radius * radius;
}

/// A difference over the size of what differs; where that is nothing, the difference itself.
inline double relative(double difference, double size)
{
    return size > 0.0 ? difference / size : difference;
}

/// Joins the particles of the DEM with the gas, both ways, every gas step: what leaves one phase is what reaches the
/// other, cell by cell and particle by particle, to round-off.
class Coupling
{
public:
    Coupling(const CouplingSettings& settings, const Foam::fvMesh& mesh, Dem& dem, Gas& gas, Timing& timing);

    bool heat() const { return heat_; }
    bool push() const { return push_; } ///< particles answer to the gas

    /// Weights and voidage for where the particles are now.
    void map();

    /// Ends the run with an error if particles lie outside the mesh.
    void refuseOutside() const;

    /// Closures at the particles; drag and heat exchange coefficients to the gas.
    void particlesToGas();

    /// Momentum and heat to the particles from the gas at the end of its step.
    void gasToParticles();

    /// Sum over all particles and ranks of |heat| exchanged in the last step [J].
    double heatExchanged() const { return heatExchanged_; }

    /// Impulse that the particles received in the last step, drag and pressure gradient, over all ranks [N s].
    const Foam::vector& impulse() const { return impulse_; }

    /// What this rank has sent to others for the exchange so far [bytes].
    std::int64_t bytesSent() const { return mapping_.bytesSent(); }

    /// What the gas equations took in the last step less what the particles received, over what was exchanged: the
    /// larger one of drag and heat. Round-off, or the coupling is broken.
    double mismatch() const { return mismatch_; }

private:
    std::unique_ptr<const Cells> makeCells(const CouplingSettings& settings);
    void closures();
    void dragOn(int particle, double B, const double* gas, double* exchange) const;
    void heatToGas();
    void heatToParticles();
    void momentumToParticles();

    const CouplingSettings settings_;
    const Foam::fvMesh& mesh_;
    Dem& dem_;
    Gas& gas_;
    Timing& timing_;
    const bool heat_;
    const bool push_;
    const int dragFields_;         ///< values of drag_ by particle; without push_ the first one is enough
    Foam::vectorField halfExtent_; ///< of each cell's bounding box [m]
    Mapping mapping_;
    bool mapped_ = false, warned_ = false;
    std::vector<char> inside_; ///< by particle: whether it lies in the mesh

    std::vector<double> halfWidth_;    ///< kernel, by particle [m]
    double widest_ = 0;                ///< largest halfWidth_ over all ranks [m]
    std::vector<double> drag_;         ///< by particle: G [kg/s], c [N] (3), V held [m3]; see dragOn
    std::vector<double> closureWork_;  ///< by particle: voidage, Reynolds, Prandtl number, beta, Nusselt number
    std::vector<double> heatGiven_;    ///< by particle: G, X, T, decay; see heatToGas
    std::vector<double> conductance_;  ///< h A, by particle [W/K]
    std::vector<double> heatReceived_; ///< heat received over a step, by particle [J]
    std::vector<double> copyHeat_;     ///< by copy: G, X, G T, G decay, G x (3)
    CellValues cellHeat_;              ///< by cell: the same, summed with the weights
    CellValues cellValues_;            ///< what is read or summed up just now
    std::vector<double> early_;        ///< by cell: how much of the exchange sees the gas before the step, [0, 1]
    Foam::scalarField temperatureBefore_;
    double heatExchanged_ = 0;
    Foam::vector impulse_ = Foam::Zero;
    double mismatch_ = 0;
};

} // namespace hotbed
