#pragma once

namespace hotbed
{

/// Mass of the one-dimensional kernel of Deen, van Sint Annaland & Kuipers (2004), eq 4/8 of the paper,
/// (15/16)(1/n)(1 - (x/n)^2)^2 on [-n, n], that lies below x; exact (it is a polynomial).
/// @param x distance from the particle over the half width n [-]; any value; one, or as many as fit in a register
/// @return 0 for x <= -1, 1 for x >= 1
template <class T> inline T deenMassBelow(T x)
{
    const T one = T{} + 1.0;
    x = x > -one ? x : -one;
    x = x < one ? x : one;
    const T x2 = x * x;
    return 0.5 + 0.9375 * x * (1.0 - x2 * (2.0 / 3.0 - 0.2 * x2));
}

} // namespace hotbed
