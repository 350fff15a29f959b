# The installed CMake package: find_package(tetloom) gives tetloom::core, ::cad, ::threading and ::mesher.
