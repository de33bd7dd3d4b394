#pragma once

#include "SHA1.H"
#include "fileName.H"

#include <cstdio>

namespace hotbed
{

/// A file that appears under its name only when all of it is on disk. Errors of writing are kept for `close`, so that
/// pieces may be written from another thread.
class WholeFile
{
public:
    explicit WholeFile(const Foam::fileName& path);
    ~WholeFile();

    void write(const char* bytes, std::size_t size);

    /// Ends the run with an error that names file and reason where something could not be written.
    /// @return SHA-1 of the file
    std::string close();

private:
    void failed();

    Foam::fileName path_, unfinished_;
    std::FILE* file_;
    int error_ = 0; ///< errno of the first failure
    Foam::SHA1 sum_;
};

/// Ends the run: a file could not be written. @param reason  errno
[[noreturn]] void cannotWrite(const Foam::fileName& path, int reason);

} // namespace hotbed
