#include "write_stream.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace hotbed
{

WriteStream::WriteStream(Take take)
{
    if (pipe(ends_) != 0) throw std::runtime_error(std::string("cannot make a pipe: ") + std::strerror(errno));
    path_ = "/proc/self/fd/" + std::to_string(ends_[1]);
    reader_ = std::thread(
        [from = ends_[0], take = std::move(take)]
        {
            std::vector<char> bytes(1 << 16);
            for (ssize_t size; (size = read(from, bytes.data(), bytes.size())) != 0;)
                if (size > 0)
                    take(bytes.data(), std::size_t(size));
                else if (errno != EINTR)
                    return;
        });
}

WriteStream::~WriteStream()
{
    close(ends_[1]); // the end of the file, once the writer has closed it too
    reader_.join();
    close(ends_[0]);
}

} // namespace hotbed
