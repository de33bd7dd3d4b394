#include "contact_kernel.hpp"

#include "contact_law.hpp"

namespace hotbed
{
namespace
{

/// Fetches what a contact needs: its particle lies anywhere in the memory.
inline void fetch(const ContactParticles& particles, const WallContact& contact)
{
    const int i = contact.particle;
    __builtin_prefetch(particles.v[i]);
    __builtin_prefetch(particles.omega[i]);
    __builtin_prefetch(particles.mass + i);
    __builtin_prefetch(contact.spring, 1);
}

template <class Vector>
inline void runWall(const ContactParticles& particles, std::vector<WallContact>& contacts,
                    const ContactConstants* constants, double timestep)
{
    Batch batch;
    fill(batch, constants[0]);
    const int count = int(contacts.size());
    for (int k = 0; k < width && k < count; ++k) fetch(particles, contacts[k]);
    for (int start = 0; start < count; start += width)
    {
        WallContact* contact = &contacts[start];
        const int n = count - start < width ? count - start : width;
        for (int k = 0; k < n; ++k)
        {
            if (start + k + width < count) fetch(particles, contact[k + width]);
            const int i = contact[k].particle;
            const ContactConstants& c = constants[contact[k].type];
            for (int a = 0; a < 3; ++a)
            {
                batch.delta[a][k] = contact[k].from[a];
                batch.velocity[a][k] = particles.v[i][a];
                batch.spin_i[a][k] = particles.omega[i][a];
                batch.stretch[a][k] = contact[k].spring[a];
            }
            batch.delta[3][k] = batch.spin_i[3][k] = particles.radius[i];
            batch.velocity[3][k] = 1.0 / particles.mass[i];
            for (int a = 0; a < 4; ++a)
            {
                batch.normal[a][k] = c.normal[a];
                batch.tangential[a][k] = c.tangential[a];
            }
        }
        law<Vector, true>(batch, timestep);
        for (int k = 0; k < n; ++k)
            for (int a = 0; a < 3; ++a)
            {
                contact[k].force[a] = batch.force[a][k];
                contact[k].torque[a] = -batch.force[3][k] * batch.turn[a][k];
                contact[k].spring[a] = batch.stretch[a][k];
            }
    }
}

__attribute__((target("arch=x86-64-v3"), flatten)) void wallAvx2(const ContactParticles& particles,
                                                                 std::vector<WallContact>& contacts,
                                                                 const ContactConstants* constants, double timestep)
{
    runWall<Row>(particles, contacts, constants, timestep);
}

__attribute__((target("arch=x86-64-v4"), flatten)) void wallAvx512(const ContactParticles& particles,
                                                                   std::vector<WallContact>& contacts,
                                                                   const ContactConstants* constants, double timestep)
{
    runWall<Wide>(particles, contacts, constants, timestep);
}

} // namespace

void wallForces(const ContactParticles& particles, std::vector<WallContact>& contacts,
                const ContactConstants* constants, double timestep)
{
    (__builtin_cpu_supports("x86-64-v4") ? wallAvx512 : wallAvx2)(particles, contacts, constants, timestep);
}

} // namespace hotbed
