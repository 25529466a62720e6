"""Other people's files: text tables, universal files, Nastran, Ansys, meshes; read as modes, FRFs and meshes in SI."""
