#pragma once

namespace hotbed
{

/// Mass of the one-dimensional kernel of Deen, van Sint Annaland & Kuipers (2004), eq 4/8 of the paper,
/// (15/16)(1/n)(1 - (x/n)^2)^2 on [-n, n], that lies below x; exact (it is a polynomial).
/// @param x distance from the particle over the half width n [-]; any value
/// @return 0 for x <= -1, 1 for x >= 1
inline double deenMassBelow(double x)
{
    x = x > -1.0 ? x : -1.0;
    x = x < 1.0 ? x : 1.0;
    const double x2 = x * x;
    return 0.5 + 0.9375 * x * (1.0 - x2 * (2.0 / 3.0 - 0.2 * x2));
}

} // namespace hotbed
