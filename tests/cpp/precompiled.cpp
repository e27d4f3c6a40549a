// The precompiled header that all test executables share is built with this source.
