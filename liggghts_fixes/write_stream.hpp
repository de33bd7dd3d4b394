#pragma once

#include <functional>
#include <string>
#include <thread>

namespace hotbed
{

/// A path that a library may open and write a file to: what it writes goes to a function instead, in order, from a
/// thread of its own. So that bytes can be counted, summed and stored with errors noticed where the library looks for
/// none.
class WriteStream
{
public:
    using Take = std::function<void(const char* bytes, std::size_t size)>;

    explicit WriteStream(Take take);
    ~WriteStream();

    /// To be opened once for writing, by this process.
    const std::string& path() const { return path_; }

private:
    int ends_[2];
    std::string path_;
    std::thread reader_;
};

} // namespace hotbed
