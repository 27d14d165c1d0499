# SPDX-License-Identifier: BSD-3-Clause
"""Pages of a run in three dimensions: spheres drawn by VTK without a display, axes by matplotlib.

The projection is parallel, so that the scale bar is right everywhere and a particle has the size on
the page that it has in the run.
"""
import math

import numpy as np

from . import colour as colours
from . import look
from .errors import modules
from .radiograph_page import scale_bar
from .view import matter
from .walls import STYLES, at_time, is_seen, walls_of

CLASSES = 8              # sizes of spheres: VTK draws those of one call in one size
SHARP = 2                # pixels of VTK a pixel of the page, along each side
LEAST = 1.5              # smallest sphere [pixels of VTK]
SPREAD = 1.15            # of spheres over the spacing of particles
WALL = 0.25              # opacity of rigid regions


def basis(azimuth, elevation):
    """Unit vectors to the right, up and towards the camera."""
    turn, lift = math.radians(azimuth), math.radians(elevation)
    towards = np.array([math.cos(lift) * math.cos(turn), math.cos(lift) * math.sin(turn),
                        math.sin(lift)])
    right = np.array([-math.sin(turn), math.cos(turn), 0.0])
    return right, np.cross(towards, right), towards


def quiet_pyvista():
    """The package pyvista without the words of VTK about displays."""
    vtk, pyvista = modules("vtk", "pyvista")
    vtk.vtkObject.GlobalWarningDisplayOff()
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
    return pyvista


class SpacePage:
    """Pages of a run in three dimensions, all with the same window and colours."""

    def __init__(self, snaps, options):
        self.options = options
        self.pyvista = quiet_pyvista()
        self.plot = look.pyplot()
        self.walls = walls_of(snaps[-1]) if options.walls else []
        self.box = self.window([matter(snap, options) for snap in snaps])
        self.metres, self.unit = look.scaled(max(self.box[1] - self.box[0],
                                                 self.box[3] - self.box[2]), "m")
        self.plotter = None

    def camera(self, share):
        """Directions of the camera after this share of a film."""
        azimuth, elevation = self.options.camera
        return basis(azimuth + share * self.options.turn, elevation)

    def window(self, parts):
        """Left, right, bottom, top that hold all particles of these times at any turn [m]."""
        if self.options.view:
            return self.options.view
        ends = [[math.inf, -math.inf], [math.inf, -math.inf]]
        shares = np.linspace(0.0, 1.0, 13) if self.options.turn else [0.0]
        for part in parts:
            half = 0.5 * part.size
            for share in shares if len(half) else []:
                for pair, direction in zip(ends, self.camera(share)):
                    along = part.points @ direction
                    pair[0] = min(pair[0], float((along - half).min()))
                    pair[1] = max(pair[1], float((along + half).max()))
        if ends[0][0] > ends[0][1]:
            return -1.0, 1.0, -1.0, 1.0
        sides = []
        pad = 0.03 * max(high - low for low, high in ends)
        for low, high in ends:
            middle, half = 0.5 * (low + high), (0.5 * (high - low) + pad) / self.options.zoom
            sides += [middle - half, middle + half]
        return tuple(sides)

    def shape(self):
        """Width and height of the picture inside the page [inch]."""
        across, tall = self.box[1] - self.box[0], self.box[3] - self.box[2]
        room = self.options.wide - 1.9
        scale = min(room / across, 7.5 / tall)
        return max(scale * across, 1.0), max(scale * tall, 1.0)

    def add_walls(self, snap):
        """Rigid regions as surfaces that are seen through, closed faces as their edges."""
        for wall in self.walls:
            pieces = at_time(wall, snap, self.options.mirror, snap.time)
            if not len(pieces) or not is_seen(wall, self.options.mirror):
                continue
            count, corners = pieces.shape[:2]
            cells = np.arange(count * corners).reshape(count, corners)
            faces = np.concatenate([np.full((count, 1), corners), cells], axis=1)
            mesh = self.pyvista.PolyData(pieces.reshape(-1, 3).astype("f4"), faces.ravel())
            tint = STYLES.get(wall.kind, STYLES["slip"])[0]
            if wall.face == 0:
                self.plotter.add_mesh(mesh, color=tint, opacity=WALL, smooth_shading=False,
                                      reset_camera=False)
            else:
                edges = mesh.clean().extract_feature_edges(feature_edges=False,
                                                           manifold_edges=False)
                self.plotter.add_mesh(edges, color=tint, line_width=2, reset_camera=False)

    def spheres(self, part, share, snap):
        """The picture of the spheres as bytes (height, width, 3)."""
        wide, high = (int(SHARP * self.options.dpi * side) for side in self.shape())
        if self.plotter is None:
            self.plotter = self.pyvista.Plotter(off_screen=True, window_size=(wide, high))
            self.plotter.set_background("white")
        plotter = self.plotter
        plotter.clear_actors()
        metres_a_pixel = (self.box[1] - self.box[0]) / wide
        tints = (255.0 * colours.paint(self.options.colour, part.values)).astype("u1")
        for rows in size_classes(part.size):
            width = max(SPREAD * float(np.median(part.size[rows])) / metres_a_pixel, LEAST)
            plotter.add_points(part.points[rows].astype("f4"), scalars=tints[rows], rgba=True,
                               render_points_as_spheres=True, point_size=width, ambient=0.35,
                               diffuse=0.75, specular=0.1, reset_camera=False)
        self.add_walls(snap)
        self.aim(part, share)
        plotter.render()
        return plotter.screenshot(return_img=True)

    def aim(self, part, share):
        """Put the camera where the window is its picture."""
        right, up, towards = self.camera(share)
        box, camera = self.box, self.plotter.camera
        middle = 0.5 * (box[0] + box[1]) * right + 0.5 * (box[2] + box[3]) * up
        held = [np.concatenate(wall.cells) for wall in self.walls if wall.cells]
        depth = np.concatenate([part.points, *held]) @ towards
        depth = depth if len(depth) else np.zeros(1)
        reach = float(depth.max() - depth.min()) + (box[1] - box[0])
        place = middle + (float(depth.max()) + reach) * towards
        camera.parallel_projection = True
        camera.focal_point, camera.position, camera.up = place - towards, place, up
        camera.parallel_scale = 0.5 * (box[3] - box[2])
        camera.clipping_range = (0.5 * reach, 3.0 * reach)

    def draw(self, snap, share=0.0):
        """The figure of one time."""
        part = matter(snap, self.options)
        image = self.spheres(part, share, snap)
        wide, high = self.shape()
        page = (wide + 1.9, high + 0.9)
        figure = self.plot.figure(figsize=page)
        axes = figure.add_axes((0.15 / page[0], 0.2 / page[1], wide / page[0], high / page[1]))
        k, box = self.metres, self.box
        axes.imshow(image, extent=[k * edge for edge in box], interpolation="antialiased",
                    aspect="equal")
        axes.set_axis_off()
        self.scale(axes)
        self.triad(figure, page, share)
        slot = figure.add_axes(((wide + 0.2) / page[0], 0.2 / page[1], 1.6 / page[0],
                                high / page[1]))
        slot.set_axis_off()
        self.colour_bar(figure, slot, page, wide, high)
        figure.text(0.15 / page[0], 1.0 - 0.1 / page[1], self.heading(part.time), va="top",
                    ha="left", fontsize=11, linespacing=1.4)
        return figure

    def heading(self, time):
        """Title and time."""
        factor, unit = self.options.clock
        head = f"{self.options.title}\n" if self.options.title else ""
        return f"{head}t = {factor * time:.4g} {unit}"

    def colour_bar(self, figure, slot, page, wide, high):
        """Colour bar, or the names of bodies."""
        if self.options.colour.names:
            colours.legend(figure, slot, self.options.colour)
            slot.get_legend().set_bbox_to_anchor((0.0, 1.0))
            return
        tall = min(high, 4.0)
        bar = figure.add_axes(((wide + 0.3) / page[0], (0.2 + 0.5 * (high - tall)) / page[1],
                               0.16 / page[0], tall / page[1]))
        colours.legend(figure, None, self.options.colour, bar)

    def scale(self, axes):
        """Scale bar below to the left."""
        k, box = self.metres, self.box
        length = scale_bar(0.25 * k * (box[1] - box[0]))
        left = k * box[0] + 0.03 * k * (box[1] - box[0])
        level = k * box[2] + 0.03 * k * (box[3] - box[2])
        axes.plot([left, left + length], [level, level], color="black", linewidth=2.5,
                  solid_capstyle="butt")
        axes.text(left + 0.5 * length, level, f"{length:g} {self.unit}\n", ha="center",
                  va="center", fontsize=10, linespacing=2.0)

    def triad(self, figure, page, share):
        """The directions x, y, z, below to the right."""
        side = 0.9
        axes = figure.add_axes((1.0 - side / page[0], 0.05 / page[1], side / page[0],
                                side / page[1]))
        right, up, towards = self.camera(share)
        for axis in np.argsort(towards):                 # those that point to us on top
            x, y = right[axis], up[axis]
            axes.annotate("", (x, y), (0.0, 0.0), arrowprops={
                "arrowstyle": "-|>", "color": look.COLOURS[axis], "linewidth": 1.8,
                "shrinkA": 0, "shrinkB": 0})
            if math.hypot(x, y) > 0.2:
                axes.text(1.25 * x, 1.25 * y, "xyz"[axis], ha="center", va="center", fontsize=10)
        axes.set_xlim(-1.4, 1.4)
        axes.set_ylim(-1.4, 1.4)
        axes.set_axis_off()


def size_classes(size):
    """Rows of particles of about the same size, some classes of them."""
    if len(size) == 0:
        return []
    order = np.argsort(size, kind="stable")
    if size[order[-1]] <= 1.05 * size[order[0]]:
        return [order]
    return [part for part in np.array_split(order, CLASSES) if len(part)]
