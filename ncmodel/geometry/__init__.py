"""Lines of a mesh: curvature, zero sets, visibility, buffers."""
