#pragma once
/// Queues data for a page. A slow page receives fewer frames instead of a queue of them.

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace haarfield {

/// Texts in order, followed by the newest frame. Not thread-safe.
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
    void set_frame(Bytes frame) { frame_ = std::move(frame); }    ///< Replaces a waiting frame.
    void shown() { unshown_ = unshown_ > 0 ? unshown_ - 1 : 0; }  ///< The page has displayed a frame.

    std::size_t text_bytes() const { return text_bytes_; }  ///< Of waiting texts.

    /// Removes and returns the next parcel to send. None if the box is empty, or if the next frame must wait
    /// until the page has displayed earlier ones.
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
    static constexpr int most_unshown = 2;  ///< The most frames that a page was sent but has not displayed.

    std::deque<Bytes> texts_;
    std::size_t text_bytes_ = 0;
    Bytes frame_;
    int unshown_ = 0;
};

}  // namespace haarfield
