#include "whole_file.hpp"

#include "error.H"

#include <cerrno>
#include <cstdlib>
#include <cstring>

using namespace Foam;

namespace hotbed
{

void cannotWrite(const fileName& path, int reason)
{
    FatalErrorInFunction
        << "cannot write " << path << ": " << std::strerror(reason)
        << ". The restarts written before are whole: make room (or the folder writable) and go on from "
        << "the last one" << exit(FatalError);
    std::abort();
}

WholeFile::WholeFile(const fileName& path)
    : path_(path), unfinished_(path + ".unfinished"), file_(std::fopen(unfinished_.c_str(), "wb"))
{
    if (!file_) failed();
}

WholeFile::~WholeFile()
{
    if (file_) std::fclose(file_);
}

void WholeFile::failed()
{
    if (!error_) error_ = errno;
}

void WholeFile::write(const char* bytes, std::size_t size)
{
    if (error_) return;
    sum_.append(bytes, size);
    if (std::fwrite(bytes, 1, size, file_) != size) failed();
}

std::string WholeFile::close()
{
    if (file_ && std::fclose(file_) != 0) failed();
    file_ = nullptr;
    if (!error_ && std::rename(unfinished_.c_str(), path_.c_str()) != 0) failed();
    if (error_)
    {
        std::remove(unfinished_.c_str()); // room for the log
        cannotWrite(path_, error_);
    }
    return sum_.digest().str();
}

} // namespace hotbed
