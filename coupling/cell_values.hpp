#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace hotbed
{

/// std::allocator that begins at a cache line.
template <class T> struct CacheLineAllocator
{
    using value_type = T;
    static constexpr std::align_val_t line{64};

    CacheLineAllocator() = default;
    template <class Other> CacheLineAllocator(const CacheLineAllocator<Other>&) {}

    T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), line)); }
    void deallocate(T* p, std::size_t) { ::operator delete(p, line); }
    template <class Other> bool operator==(const CacheLineAllocator<Other>&) const { return true; }
    template <class Other> bool operator!=(const CacheLineAllocator<Other>&) const { return false; }
};

/// Values by cell, [cells][fields]: with 8 fields a cell fills just one cache line.
using CellValues = std::vector<double, CacheLineAllocator<double>>;

} // namespace hotbed
