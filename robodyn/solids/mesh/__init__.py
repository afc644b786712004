"""Mesh files to mass properties: read/, prove closed/, repair/ and region/, integrate/, symmetry/ and tessellation/.

Here beside the rooms: `triangles` in blocks, `indexed` by vertices (equal ones by `distinct`), `blocks` of rows;
`measured` (read, repaired, integrated, and as mass properties) and `shape` (symmetry and tessellation of what was
measured).
"""
