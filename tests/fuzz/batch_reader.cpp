#include "tests/fuzz/batch_reader.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <new>

#include "fields/base/exception_message.h"
#include "fields/base/sanitizers.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {

/// Memory of both processes.
struct BatchReader::Shared {
    std::array<char, 4096> file;      ///< Its path, ending with 0.
    std::array<char, 256> details;    ///< Ending with 0.
    std::size_t size;                 ///< Of the answer. [bytes]
    std::array<char, 1 << 25> bytes;  ///< The answer, or the error of the task.
};

namespace {

enum class Answer : char { done, refused, crashed };

void limit_reader() {
    std::set_new_handler(nullptr);  // the worker of a reader process refuses files that need too much memory
    if (has_shadow_memory) return;
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t limit = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t(1) << 26);
    const rlimit memory{limit, limit};
    setrlimit(RLIMIT_AS, &memory);
}

/// Ends the process after this many seconds of processor time; 0: never.
void limit_time(time_t seconds) {
    const itimerval limit{{0, 0}, {seconds, 0}};
    setitimer(ITIMER_PROF, &limit, nullptr);
}

template <std::size_t size>
void set_text(std::array<char, size>& text, std::string_view value) {
    if (value.size() >= size) throw std::length_error("too long");
    std::ranges::copy(value, text.begin());
    text[value.size()] = 0;
}

bool send(int pipe, char message) {
    return write(pipe, &message, 1) == 1;
}

}  // namespace

BatchReader::BatchReader(const ReaderTask& task) {
    void* const memory =
        mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    int requests[2], answers[2];
    if (memory == MAP_FAILED || pipe(requests) != 0 || pipe(answers) != 0) throw std::bad_alloc();
    shared_ = new (memory) Shared;
    requests_ = requests[1];
    answers_ = answers[0];
    const auto append = [this](std::string_view piece) {
        if (piece.size() > shared_->bytes.size() - shared_->size) throw std::bad_alloc();
        std::ranges::copy(piece, shared_->bytes.begin() + std::ptrdiff_t(shared_->size));
        shared_->size += piece.size();
    };
    const auto answer = [&] {
        const auto refused = [&](std::string_view what) {
            shared_->size = 0;
            append(what);
            return Answer::refused;
        };
        try {
            ByteSink sink(append);
            const std::string bytes = text_of(shared_->file.data());
            const Result<Done> read = task.read(bytes, shared_->details.data(), sink);
            return read ? Answer::done : refused(read.error().what);
        } catch (const std::exception& problem) {
            return refused(exception_message(problem));
        }
    };
    if (fork() != 0) {  // on failure, the first read fails
        ::close(requests[0]);
        ::close(answers[1]);
        return;
    }
    ::close(requests[1]);
    ::close(answers[0]);
    while (true) {
        const pid_t reader = fork();
        if (reader == 0) {
            constexpr time_t most_seconds = 5;
            limit_reader();
            for (char unused = 0; ::read(requests[0], &unused, 1) == 1;) {
                limit_time(most_seconds);
                shared_->size = 0;
                const Answer given = answer();
                limit_time(0);
                if (!send(answers[1], static_cast<char>(given))) break;
            }
            _exit(0);
        }
        int status = 0;
        const bool has_crashed = reader > 0 && waitpid(reader, &status, 0) == reader &&
                                 !(WIFEXITED(status) && WEXITSTATUS(status) == 0);
        if (!has_crashed || !send(answers[1], static_cast<char>(Answer::crashed))) _exit(0);
    }
}

BatchReader::~BatchReader() {
    ::close(requests_);
    ::close(answers_);
    munmap(shared_, sizeof(Shared));
}

Result<MappedFile> BatchReader::read(const std::filesystem::path& file, std::string_view details) {
    const std::string where = file.string();
    set_text(shared_->file, where);
    set_text(shared_->details, details);
    char given = 0;
    if (!send(requests_, 0) || ::read(answers_, &given, 1) != 1)
        return Error{where, "its reader ended: no process"};
    if (Answer(given) == Answer::crashed) return Error{where, "its reader ended: the file is damaged"};
    const std::string_view bytes(shared_->bytes.data(), shared_->size);
    if (Answer(given) == Answer::refused) return Error{where, std::string(bytes)};
    const auto copy = std::make_shared<const std::string>(bytes);
    return MappedFile{*copy, copy};
}

}  // namespace haarfield
