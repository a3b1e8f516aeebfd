// OpenImageIO leaks strings of its reader when libpng reports a damaged PNG by longjmp. The library has no
// frame pointers, so that the report often contains only the assignment of a string. This hides no leak of
// haarfield, whose strings are members of objects that would be reported themselves.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libOpenImageIO\nleak:_M_assign\n";
}

// oneTBB's library, which is not instrumented, waits for the counter of a node on the stack or for a context,
// and this memory is then reused. No body of a loop is called from there. Embree and OpenImageIO are not
// instrumented either, and free data that their threads have allocated. OpenVDB compresses and frees leaves
// in oneTBB's threads.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
    return "race:fold_tree\nrace:task_group_context::state\n"
           "race:libembree\nrace:libOpenImageIO\nrace:openvdb\n";
}

// Tests fork while oneTBB's threads exist. OpenVDB allocates what damaged files ask for.
extern "C" const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() {
    return "die_after_fork=0:allocator_may_return_null=1";
}
