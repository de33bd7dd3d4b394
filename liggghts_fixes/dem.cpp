#include "liggghts.hpp"

#include "dem.hpp"

#include "fix_hotbed_balance.h"
#include "fix_hotbed_carried.h"
#include "fix_hotbed_coarsegrain.h"
#include "fix_hotbed_drag.h"
#include "fix_hotbed_heat.h"
#include "contact_constants.hpp"
#include "fix_nve_sphere_hotbed.h"
#include "register_contact.hpp"
#include "runaway.hpp"
#include "write_stream.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

/// The line of the script that LIGGGHTS is at, which is protected.
struct ScriptLine : Input
{
    static const char* of(Input& input) { return input.*(&ScriptLine::line); }
};

/// What to do where the units are others, else nothing.
std::string unitsMend(const LAMMPS& lmp)
{
    const std::string units = lmp.update->unit_style;
    return units == "si" ? "" : "the units are " + units + ": begin the script with 'units si'";
}

/// What LIGGGHTS prints goes to its log file; its errors and warnings also to stderr, with the script's name.
struct ErrorStream
{
    std::string script, line;
    LAMMPS* reading = nullptr;       ///< in the script
    const LAMMPS* running = nullptr; ///< in the time loop, where particles may be to blame

    static ssize_t write(void* self, const char* text, std::size_t size)
    {
        auto& stream = *static_cast<ErrorStream*>(self);
        for (std::size_t i = 0; i < size; ++i)
        {
            if (text[i] != '\n')
            {
                stream.line += text[i];
                continue;
            }
            if (stream.line.compare(0, 5, "ERROR") == 0 || stream.line.compare(0, 7, "WARNING") == 0)
                std::fprintf(stderr, "LIGGGHTS, %s: %s\n", stream.script.c_str(), stream.line.c_str());
            if (stream.reading && stream.line.compare(0, 5, "ERROR") == 0)
            {
                std::fprintf(stderr, "LIGGGHTS, %s: at the line: %s\n", stream.script.c_str(),
                             ScriptLine::of(*stream.reading->input));
                const std::string mend = unitsMend(*stream.reading);
                if (!mend.empty()) std::fprintf(stderr, "LIGGGHTS, %s: %s\n", stream.script.c_str(), mend.c_str());
            }
            if (stream.running && stream.line.compare(0, 5, "ERROR") == 0 &&
                stream.line.find("blew up") == std::string::npos) // that one names its particle
                std::fprintf(stderr, "The fastest on this rank was %s. The restarts written before are whole.\n",
                             hotbed::fastest(*stream.running).c_str());
            stream.line.clear();
        }
        return ssize_t(size);
    }
};

} // namespace

struct Dem::Instance
{
    ErrorStream errors;
    std::unique_ptr<LAMMPS> lmp;
    FixHotbedHeat* heat = nullptr;
    FixHotbedDrag* drag = nullptr;
    FixHotbedCoarsegrain* coarsegrain = nullptr;
    FixHotbedCarried* carried = nullptr;
    bool moving = true;

    template <class Style> Style* find() const
    {
        for (int i = 0; i < lmp->modify->nfix; ++i)
            if (auto* fix = dynamic_cast<Style*>(lmp->modify->fix[i])) return fix;
        return nullptr;
    }
};

Dem::Dem(MPI_Comm communicator, const std::string& log) : instance_(new Instance)
{
    if (!std::ofstream(log, std::ios::app)) // LIGGGHTS, without a screen yet, could not say so
        throw std::runtime_error("cannot write '" + log + "': " + std::strerror(errno));

    std::vector<std::string> words = {"hotbed", "-log", log, "-screen", "none"};
    std::vector<char*> arg;
    for (std::string& word : words) arg.push_back(&word[0]);
    instance_->lmp.reset(new LAMMPS(int(arg.size()), arg.data(), communicator));
}

std::string Dem::version() const
{
    return instance_->lmp->universe->version;
}

void Dem::divide(const std::array<int, 3>& pieces)
{
    std::string command = "processors";
    for (int n : pieces) command += n > 0 ? ' ' + std::to_string(n) : " *";
    instance_->lmp->input->one((command + " map xyz").c_str()); // the ranks in OpenFOAM's order
}

void Dem::read(const std::string& script, const std::vector<std::pair<std::string, std::string>>& variables)
{
    if (!std::ifstream(script)) throw std::runtime_error("cannot read the DEM script '" + script + "'");

    instance_->errors.script = script;
    cookie_io_functions_t io = {};
    io.write = &ErrorStream::write;
    FILE* screen = fopencookie(&instance_->errors, "w", io);
    std::setvbuf(screen, nullptr, _IONBF, 0);
    LAMMPS& lmp = *instance_->lmp;
    lmp.screen = screen;
    for (auto [name, value] : variables)
    {
        char* words[] = {&value[0]};
        lmp.input->variable->set(&name[0], 1, words); // as -var does
    }
    instance_->errors.reading = &lmp;
    lmp.input->file(script.c_str());
    instance_->errors.reading = nullptr;

    if (lmp.domain->box_exist == 0)
        throw std::runtime_error("the DEM script '" + script +
                                 "' makes no simulation box: add create_box or "
                                 "read_restart, and particles");
    const std::string mend = unitsMend(lmp);
    if (!mend.empty()) throw std::runtime_error("in the DEM script '" + script + "' " + mend);
    const Range timestep = {0.0, false};
    if (!lmp.update->timestep_set || !timestep.holds(lmp.update->dt))
        throw std::runtime_error("timestep " +
                                 (lmp.update->timestep_set ? "is " + std::to_string(lmp.update->dt) : "is missing") +
                                 " in the DEM script '" + script + "': add 'timestep dt', " + timestep.text() + " [s]");
    instance_->heat = instance_->find<FixHotbedHeat>();
    instance_->drag = instance_->find<FixHotbedDrag>();
    instance_->coarsegrain = instance_->find<FixHotbedCoarsegrain>();
    instance_->moving = false;
    for (int i = 0; i < lmp.modify->nfix; ++i)
    {
        // insertion asks for new neighbour lists; so do two that move no particle
        const Fix& fix = *lmp.modify->fix[i];
        const bool other = std::strncmp(fix.style, "mesh/", 5) == 0 || dynamic_cast<const FixHotbedBalance*>(&fix);
        instance_->moving |= fix.time_integrate != 0 || (fix.force_reneighbor != 0 && !other);
    }
}

Dem::~Dem() = default;

std::vector<ContactTime> Dem::contacts()
{
    LAMMPS& lmp = *instance_->lmp;
    lmp.init();
    if (!hasContacts() || otherContacts()) return {};
    return contactTimes(lmp, contactTable(lmp));
}

bool Dem::hasContacts() const
{
    return instance_->lmp->force->pair;
}

bool Dem::otherContacts() const
{
    auto* gran = dynamic_cast<PairGran*>(instance_->lmp->force->pair);
    return hasContacts() && !(gran && gran->hashcode() == contactCode());
}

void Dem::setup(bool resumed)
{
    LAMMPS& lmp = *instance_->lmp;
    Update& update = *lmp.update;
    update.whichflag = 1;
    update.nsteps = std::numeric_limits<int>::max();
    update.firststep = update.beginstep = update.ntimestep;
    update.laststep = update.endstep = update.ntimestep + update.nsteps;
    lmp.init();
    lmp.timer->init();
    lmp.modify->timing = 1;
    update.integrate->setup();
    if (resumed && instance_->drag) instance_->drag->restoreForces();
    refuseRunaways(lmp);
    instance_->errors.running = &lmp;
}

void Dem::writeRestart(const std::function<void(const char* bytes, std::size_t size)>& take)
{
    LAMMPS& lmp = *instance_->lmp;
    // as after reading: the same order of particles, the same neighbour lists, so that both go on to the last digit
    if (instance_->drag && instance_->moving)
    {
        instance_->drag->keepForces();
        lmp.update->integrate->setup();
        instance_->drag->restoreForces();
    }
    // the springs of the contacts live in the neighbour lists; LIGGGHTS saves what its fix took from them at the last
    // rebuild, which may be long ago
    for (int i = 0; i < lmp.modify->nfix; ++i)
        if (std::strcmp(lmp.modify->fix[i]->style, "contacthistory") == 0) lmp.modify->fix[i]->pre_exchange();
    const std::unique_ptr<WriteStream> stream(lmp.comm->me == 0 ? new WriteStream(take) : nullptr);
    std::string path = stream ? stream->path() : "none"; // only the first rank opens it
    WriteRestart(&lmp).write(&path[0]);
}

std::array<double, 3> Dem::gravity() const
{
    const Modify& modify = *instance_->lmp->modify;
    std::array<double, 3> sum = {};
    for (int i = 0; i < modify.nfix; ++i)
    {
        double own[3] = {};
        if (auto* fix = dynamic_cast<FixGravity*>(modify.fix[i])) fix->get_gravity(own);
        if (auto* fix = dynamic_cast<FixNVESphereHotbed*>(modify.fix[i])) std::copy_n(fix->gravity(), 3, own);
        for (std::size_t a = 0; a < 3; ++a) sum[a] += own[a];
    }
    return sum;
}

int Dem::size() const
{
    return instance_->lmp->atom->nlocal;
}

namespace
{

/// LIGGGHTS keeps two-dimensional arrays in one block behind row pointers
template <int n = 3> double (*block(double** rows))[n]
{
    return rows ? reinterpret_cast<double(*)[n]>(rows[0]) : nullptr;
}

} // namespace

const double (*Dem::position() const)[3]
{
    return block(instance_->lmp->atom->x);
}

const double (*Dem::velocity() const)[3]
{
    return block(instance_->lmp->atom->v);
}

const double* Dem::radius() const
{
    return instance_->lmp->atom->radius;
}

double Dem::largestRadius() const
{
    double largest, smallest;
    instance_->lmp->modify->max_min_rad(largest, smallest);
    return largest;
}

const double* Dem::mass() const
{
    return instance_->lmp->atom->rmass;
}

const int* Dem::tag() const
{
    return instance_->lmp->atom->tag;
}

double Dem::ratio() const
{
    return instance_->coarsegrain ? instance_->coarsegrain->ratio() : 1.0;
}

double Dem::timestep() const
{
    return instance_->lmp->update->dt;
}

long Dem::step() const
{
    return long(instance_->lmp->update->ntimestep);
}

bool Dem::moving() const
{
    return instance_->moving;
}

bool Dem::heat() const
{
    return instance_->heat != nullptr;
}

bool Dem::drag() const
{
    return instance_->drag != nullptr;
}

const double (*Dem::gasForce() const)[3]
{
    return block(instance_->drag->force());
}

void Dem::setGasForce(int first, int count, const double (*force)[3])
{
    instance_->drag->set(first, count, force);
}

double (*Dem::gasAlone() const)[4]
{
    return block<4>(instance_->drag->alone());
}

const double (*Dem::force() const)[3]
{
    return block(instance_->lmp->atom->f);
}

void Dem::carry(int values)
{
    std::vector<const char*> arg = {
        "hotbedCarried", "all", "hotbed/carried", "hotbedCarried", "vector_one_entry", "no", "no", "no"};
    arg.insert(arg.end(), std::size_t(values), "0.");
    if (values > 1) arg[4] = "vector";
    instance_->lmp->modify->add_fix(int(arg.size()), const_cast<char**>(arg.data()));
    instance_->carried = instance_->find<FixHotbedCarried>();
}

double* Dem::carried() const
{
    double** rows = instance_->carried->array_atom;
    return rows ? rows[0] : nullptr;
}

bool Dem::newParticles()
{
    return std::exchange(instance_->carried->newParticles, false);
}

double Dem::largestOverlap(int* particle) const
{
    LAMMPS& lmp = *instance_->lmp;
    const Atom& atom = *lmp.atom;
    const double* radius = atom.radius;
    double largest = 0;
    const auto seen = [&](int i, double overlap)
    {
        if (overlap <= largest) return;
        largest = overlap;
        if (particle) *particle = i;
    };
    if (const auto* pair = dynamic_cast<const PairGran*>(lmp.force->pair))
    {
        const NeighList& list = *pair->list;
        for (int ii = 0; ii < list.inum; ++ii)
        {
            const int i = list.ilist[ii];
            const double* x = atom.x[i];
            for (int k = 0; k < list.numneigh[i]; ++k)
            {
                const int j = list.firstneigh[i][k] & NEIGHMASK;
                const double* y = atom.x[j];
                const double dx = x[0] - y[0], dy = x[1] - y[1], dz = x[2] - y[2];
                const double reach = radius[i] + radius[j], square = dx * dx + dy * dy + dz * dz;
                if (square < reach * reach) seen(i, (reach - std::sqrt(square)) / (2 * std::min(radius[i], radius[j])));
            }
        }
    }
    for (int f = 0; f < lmp.modify->nfix; ++f)
    {
        auto* wall = dynamic_cast<FixWallGran*>(lmp.modify->fix[f]);
        if (!wall || wall->is_mesh_wall()) continue;
        int* near = nullptr;
        const int count = wall->primitiveWall()->getNeighbors(near);
        for (int k = 0; k < count; ++k)
        {
            const int i = near[k];
            if (i >= atom.nlocal || !(atom.mask[i] & wall->groupbit)) continue;
            double normal[3];
            const double gap = wall->primitiveWall()->resolveContact(atom.x[i], radius[i], normal);
            seen(i, -gap / (2 * radius[i]));
        }
    }
    return largest;
}

std::string Dem::describe(int particle) const
{
    return hotbed::describe(*instance_->lmp, particle);
}

std::string Dem::fastest() const
{
    return hotbed::fastest(*instance_->lmp);
}

double* Dem::temperature() const
{
    return instance_->heat->temperature();
}

double* Dem::nusselt() const
{
    return instance_->heat->nusselt();
}

void Dem::heatCapacity(int first, int count, double* capacity) const
{
    instance_->heat->heatCapacity(first, count, capacity);
}

double Dem::thermalEnergy() const
{
    return instance_->heat->compute_scalar();
}

void Dem::warm(int first, int count, const double* change)
{
    instance_->heat->warm(first, count, change);
}

void Dem::advance(int steps)
{
    LAMMPS& lmp = *instance_->lmp;
    if (instance_->moving)
    {
        for (int i = 0; i < lmp.modify->nfix; ++i)
            if (auto* integration = dynamic_cast<FixNVESphereHotbed*>(lmp.modify->fix[i]))
                integration->stopAfter(lmp.update->ntimestep + steps);
        lmp.update->integrate->run(steps);
        refuseRunaways(lmp);
        return;
    }
    for (int s = 0; s < steps; ++s)
    {
        ++lmp.update->ntimestep;
        if (lmp.modify->n_end_of_step) lmp.modify->end_of_step();
        if (lmp.update->ntimestep == lmp.output->next) lmp.output->write(lmp.update->ntimestep);
    }
}

std::vector<std::pair<std::string, double>> Dem::times() const
{
    if (!instance_->moving) return {};
    const LAMMPS& lmp = *instance_->lmp;
    const double* phase = lmp.timer->array;
    double walls = 0.0, integration = 0.0, others = 0.0;
    for (int i = 0; i < lmp.modify->nfix; ++i)
    {
        Fix& fix = *lmp.modify->fix[i];
        const double seconds = fix.get_recorded_time();
        (std::strncmp(fix.style, "wall/", 5) == 0 ? walls : fix.time_integrate ? integration : others) += seconds;
    }
    return {
        {"contacts", phase[TIME_PAIR]}, {"neighbour lists", phase[TIME_NEIGHBOR]}, {"walls", walls},
        {"integration", integration},   {"gravity and other fixes", others},       {"communication", phase[TIME_COMM]},
        {"output", phase[TIME_OUTPUT]}};
}

void Dem::finish()
{
    instance_->lmp->update->integrate->cleanup();
    instance_->lmp->update->whichflag = 0;
}

} // namespace hotbed
