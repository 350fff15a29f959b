# Used by the `tsan` preset: an oneTBB built with the thread sanitizer in place of the packaged one, whose
# uninstrumented synchronisation gives spurious reports.
execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/../scripts/build_tsan_tbb.sh
                OUTPUT_VARIABLE tetloom_tsan_tbb OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
set(TBB_DIR ${tetloom_tsan_tbb} CACHE PATH "oneTBB built with the thread sanitizer" FORCE)
