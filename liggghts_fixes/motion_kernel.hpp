#pragma once

/// Half steps of fix nve/sphere/hotbed for many particles at a time. Knows arrays only.

namespace hotbed
{

enum Half
{
    FIRST,
    SECOND, ///< the complete force is left in the array of forces
    SECOND_AND_FIRST
};

/// LIGGGHTS' particles: x, v, force, omega, torque and gas are [number][3] each
struct MovingParticles
{
    int number;
    double *x, *v, *force, *omega;
    const double* torque;
    const double* gas; ///< [N], null: none
    const double* radius;
    const double* mass;
    const int* mask;
};

struct MotionStep
{
    int groupbit;             ///< of those that move
    double drift, kick, turn; ///< dt; of v by force/m and of omega by torque/(m r^2)
    const double* gravity;    ///< [m/s2], null: the force is complete
};

/// @param way  square of the longest way of any particle along each axis [m2]; not below what it was
void move(Half half, const MovingParticles& particles, const MotionStep& step, double* way);

} // namespace hotbed
