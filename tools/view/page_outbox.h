#pragma once
/// What waits to be sent to a page: a slow page gets fewer frames, and no queue of them.

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace haarfield {

/// Texts in their order, and the newest frame behind them. No thread is guarded against another.
class PageOutbox {
public:
    using Bytes = std::shared_ptr<const std::string>;

    struct Parcel {
        bool is_frame;
        Bytes bytes;
    };

    void add_text(std::string text) {
        text_bytes_ += text.size();
        texts_.push_back(std::make_shared<const std::string>(std::move(text)));
    }
    void set_frame(Bytes frame) { frame_ = std::move(frame); }    ///< Instead of one that still waits.
    void shown() { unshown_ = unshown_ > 0 ? unshown_ - 1 : 0; }  ///< The page has shown a frame.

    std::size_t text_bytes() const { return text_bytes_; }  ///< Of texts that wait.

    /// What is to be sent next, which waits no longer; none if there is nothing, or if a frame has to wait
    /// until the page has shown others.
    std::optional<Parcel> take() {
        if (!texts_.empty()) {
            Bytes text = std::move(texts_.front());
            texts_.pop_front();
            text_bytes_ -= text->size();
            return Parcel{false, std::move(text)};
        }
        if (!frame_ || unshown_ >= most_unshown) return std::nullopt;
        ++unshown_;
        return Parcel{true, std::exchange(frame_, nullptr)};
    }

private:
    static constexpr int most_unshown = 2;  ///< Frames that a page has been sent and has not shown.

    std::deque<Bytes> texts_;
    std::size_t text_bytes_ = 0;
    Bytes frame_;
    int unshown_ = 0;
};

}  // namespace haarfield
