"""Meshes of the scene as an .obj for --scene: metres, +Y up, an object each."""

from .armature import y_up


def file_name(thing):
    return "_".join(thing.name.split())


def write_scene(context, objects, path):
    graph = context.evaluated_depsgraph_get()
    count = 0
    with open(path, "w", encoding="utf-8") as out:
        for thing in objects:
            evaluated = thing.evaluated_get(graph)
            mesh = evaluated.to_mesh()
            mesh.calc_loop_triangles()
            out.write(f"o {file_name(thing)}\n")
            for vertex in mesh.vertices:
                out.write("v %.6f %.6f %.6f\n" % tuple(y_up(thing.matrix_world @ vertex.co)))
            for triangle in mesh.loop_triangles:
                out.write("f %d %d %d\n" % tuple(count + 1 + v for v in triangle.vertices))
            count += len(mesh.vertices)
            evaluated.to_mesh_clear()
