// OpenImageIO leaves its reader's strings behind when libpng jumps out of a damaged PNG; nothing of ours is
// meant. Its library has no frame pointers, so that often all that is known is the string's assignment: of
// ours a string can not be lost without what it is a member of.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libOpenImageIO\nleak:_M_assign\n";
}

// oneTBB counts down in a node that its library waits for, which is not instrumented; then the node's place
// on the stack is used again. No body of a loop is called from there. Embree and OpenImageIO are not
// instrumented, either: these free what threads of theirs have made.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
    return "race:fold_tree\nrace:libembree\nrace:libOpenImageIO\n";
}

// Tests fork, with oneTBB's threads about.
extern "C" const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() {
    return "die_after_fork=0";
}
