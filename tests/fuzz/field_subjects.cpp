#include "tests/fuzz/field_subjects.h"

#include <bit>
#include <cmath>

#include "fields/field/ambient_visibility.h"
#include "fields/field/field_file.h"
#include "fields/field/field_grids.h"
#include "fields/field/field_transfer.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/forged_grids.h"
#include "tests/fuzz/batch_reader.h"

namespace haarfield {
namespace {

using std::filesystem::path;

/// Returns the bytes by which fields are compared.
std::string content_of(const VisibilityField& field) {
    return *field_file_bytes(field);
}

/// Returns the files of four small fields. The grids for other programs have few voxels, most of them outside
/// the reach of the field and thus inactive, so that a file is read in about a millisecond.
std::vector<std::string> small_files() {
    std::vector<std::string> files;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        VisibilityField field = random_field(seed, 50 * seed);
        field.bounds = {Vec3f(-1, 0, -0.0f), Vec3f(1, 0.1f * float(seed), 0.1f)};
        field.planar.outer_radius = field.spherical.outer_radius = 0.25f;
        files.push_back(content_of(field));
    }
    return files;
}

/// Null if a reader process reads the files.
std::unique_ptr<BatchReader> batch_reader;

/// Reads a field like read_field, with the batch reader if there is one.
Result<VisibilityField> field_of(const path& file) {
    if (!batch_reader) return read_field(file);
    HF_TRY(const MappedFile bytes, batch_reader->read(file, "whole"));
    Result<VisibilityField> field = transferred_field(bytes);
    if (!field) return Error{file.string(), field.error().what};
    if (const std::string defect = field_defect(*field); !defect.empty()) return Error{file.string(), defect};
    return field;
}

/// Returns flags of openvdb::io. Files without COMPRESS_ACTIVE_MASK are large and slow.
std::uint32_t any_compression(FuzzRandom& random) {
    using namespace openvdb::io;
    constexpr std::size_t rare = 32;
    if (random_index(random, rare) == 0) return random_index(random, 2) ? COMPRESS_ZIP : COMPRESS_NONE;
    constexpr std::uint32_t others[]{COMPRESS_NONE, COMPRESS_ZIP, COMPRESS_BLOSC};
    return COMPRESS_ACTIVE_MASK | others[random_index(random, std::size(others))];
}

class DamagedFields : public Subject {
public:
    DamagedFields() {
        using namespace openvdb::io;
        for (const std::string& file : fields_) {
            // Damage to compressed values only tests the decompression.
            files_.push_back(file);
            for (const auto compression :
                 {std::uint32_t(COMPRESS_ACTIVE_MASK), std::uint32_t(COMPRESS_ZIP | COMPRESS_ACTIVE_MASK)})
                files_.push_back(file_of(grids_of(file), compression));
        }
    }
    std::string file_name() const override { return "field.vdb"; }
    std::string input(FuzzRandom& random) override {
        std::string bytes = files_[random_index(random, files_.size())];
        damage(bytes, random, files_[random_index(random, files_.size())], {});
        return bytes;
    }
    std::string objection(const path& file, Outcome& outcome) override {
        const Result<VisibilityField> field = field_of(file);
        if (!field) return outcome.refused(field.error());
        outcome.accepted = true;
        return std::ranges::count(fields_, content_of(*field)) ? "" : "a changed field was accepted";
    }

private:
    const std::vector<std::string> fields_ = small_files();
    std::vector<std::string> files_;
};

class ForgedFields : public Subject {
public:
    ForgedFields() {
        for (const std::string& file : small_files()) fields_.push_back(grids_of(file));
    }
    std::string file_name() const override { return "forged.vdb"; }
    std::string input(FuzzRandom& random) override {
        openvdb::GridPtrVec grids;
        for (const auto& grid : fields_[random_index(random, fields_.size())])
            grids.push_back(grid->copyGrid());  // shares the tree
        for (std::size_t changes = 1 + random_index(random, 3); changes > 0; --changes) {
            auto& grid = grids[random_index(random, grids.size())];
            grid = grid->deepCopyGrid();
            change(*grid, random);
        }
        constexpr std::size_t rare = 16;
        if (random_index(random, rare) == 0)
            grids.erase(grids.begin() + std::ptrdiff_t(random_index(random, grids.size())));
        if (random_index(random, rare) == 0) grids.push_back(grids[random_index(random, grids.size())]);
        rehash(grids);
        return file_of(grids, any_compression(random));
    }
    std::string objection(const path& file, Outcome& outcome) override {
        const Result<VisibilityField> field = field_of(file);
        if (!field) return outcome.refused(field.error());
        outcome.accepted = true;
        if (const std::string defect = field_defect(*field); !defect.empty()) return "accepted: " + defect;
        // Traverse every tree, look up samples everywhere, and compute the grids.
        mean_over_directions(field->pool);
        for (int i = 0; i < 20; ++i) {
            const float t = static_cast<float>(i);
            const Vec3f point(t * std::cos(t), t * 0.1f, t * std::sin(t));
            interpolated_visibility(*field, field->planar_handles, field->planar.interpolation(point));
            interpolated_visibility(*field, field->spherical_handles, field->spherical.interpolation(point));
        }
        if (const Result<Done> verdict = verify_field(file); !verdict && verdict.error().what.empty())
            return "refused without a reason";
        return {};
    }

private:
    /// Changes a voxel of a table or a number in the metadata.
    static void change(openvdb::GridBase& grid, FuzzRandom& random) {
        const std::int32_t numbers[] = {0, -1, 1, 2, 50, 255, 1 << 20, 0x7fffffff, std::int32_t(random())};
        const std::int32_t number = numbers[random_index(random, std::size(numbers))];
        if (grid.isType<openvdb::Int32Grid>() && random_index(random, 3))
            change_voxel(static_cast<openvdb::Int32Grid&>(grid), number, random);
        else
            change_metadata(grid, number, random);
    }

    static void change_voxel(openvdb::Int32Grid& table, std::int32_t number, FuzzRandom& random) {
        const auto count = std::uint64_t(table.metaValue<openvdb::Int64>("haarfield_count"));
        if (count == 0) return;
        const openvdb::Coord voxel =
            voxel_of(table, random_index(random, std::min<std::uint64_t>(count, 1 << 20)));
        switch (random_index(random, 12)) {
            case 0: table.tree().setValueOff(voxel, number); break;
            case 1:
                table.tree().setValueOn(voxel.offsetBy(int(random()) >> random_index(random, 32)), number);
                break;
            case 2: table.tree().addTile(1, voxel, number, random_index(random, 2) == 0); break;
            case 3: table.tree().addTile(2, voxel, number, random_index(random, 8) == 0); break;
            case 4: table.tree().voxelizeActiveTiles(); break;
            default: table.tree().setValueOn(voxel, number);
        }
    }

    static void change_metadata(openvdb::GridBase& grid, std::int32_t number, FuzzRandom& random) {
        auto meta = grid.beginMeta();
        std::advance(meta, random_index(random, grid.metaCount()));
        const std::string name = meta->first, type = meta->second->typeName();
        if (name == "haarfield_angles" || name == "haarfield_polar" || name == "haarfield_azimuths" ||
            name == "haarfield_count")
            return;  // voxel_of needs them
        if (type == "int32") grid.insertMeta(name, openvdb::Int32Metadata(number));
        if (type == "int64") grid.insertMeta(name, openvdb::Int64Metadata(number));
        if (type == "float") grid.insertMeta(name, openvdb::FloatMetadata(std::bit_cast<float>(number)));
    }

    std::vector<openvdb::GridPtrVec> fields_;
};

}  // namespace

void read_fields_in_batches() {
    batch_reader = std::make_unique<BatchReader>(field_reader_task());
}

std::unique_ptr<Subject> damaged_fields() {
    return std::make_unique<DamagedFields>();
}

std::unique_ptr<Subject> forged_fields() {
    return std::make_unique<ForgedFields>();
}

}  // namespace haarfield
