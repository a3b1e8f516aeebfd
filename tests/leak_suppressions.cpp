// OpenImageIO leaves its reader's strings behind when libpng jumps out of a damaged PNG; nothing of ours is meant.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libOpenImageIO\n"; }
