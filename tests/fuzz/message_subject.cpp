#include <nlohmann/json.hpp>

#include "tests/fixtures/test_folder.h"
#include "tests/fixtures/view_messages.h"
#include "tests/fuzz/json_changes.h"
#include "tests/fuzz/json_subjects.h"
#include "tests/fuzz/structured_changes.h"

namespace haarfield {
namespace {

class DamagedMessages : public Subject {
public:
    std::string file_name() const override { return "message.json"; }
    std::string input(FuzzRandom& random) override {
        std::string text = any(random);
        switch (random_index(random, 8)) {
            case 0: damage(text, random, any(random), words()); return text;
            case 1: change_structure(text, random, FileKind::text); return text;
            // Merges keys of another type.
            case 2: {
                auto json = nlohmann::ordered_json::parse(text);
                json.update(nlohmann::ordered_json::parse(any(random)));
                return changed_json(std::move(json), random);
            }
            default: return changed_json(nlohmann::ordered_json::parse(text), random);
        }
    }
    std::string objection(const std::filesystem::path& file, Outcome& outcome) override {
        const std::string text = text_of(file);
        const Result<Message> message = read_message(text);
        if (message) {
            outcome.accepted = true;
            return message_defect(*message);
        }
        // Like the session's answer.
        const std::string answer = message_text({{"type", "error"}, {"message", message.error().what}});
        if (answer.size() > 400) return "an error of " + std::to_string(answer.size()) + " bytes";
        return outcome.refused(message.error());
    }

private:
    static const std::string& any(FuzzRandom& random) {
        return good_messages()[random_index(random, good_messages().size())];
    }
    static const std::vector<std::string_view>& words() {
        static const std::vector<std::string_view> words{
            "null", "\"auto\"",    "1e999", "-0.0",      "[[[[[[[[", "\"\\ud800\"", "18446744073709551616",
            "{}",   "NaN",         "\xc3",  "\"type\":", ",",        "\"number\":", "\"gesture\":4294967295,",
            "[1,",  "\"\\u0000\"", "true"};
        return words;
    }
};

}  // namespace

std::unique_ptr<Subject> damaged_messages() {
    return std::make_unique<DamagedMessages>();
}

}  // namespace haarfield
