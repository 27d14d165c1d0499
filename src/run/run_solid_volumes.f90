! SPDX-License-Identifier: BSD-3-Clause
!> Lines of `--check` that compare the volume of a shape with that of the particles which fill it.
module run_solid_volumes
   use base_kinds, only: int64, wp
   use base_text, only: brief, number
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   use particle_disks, only: disks_t
   use particle_facets, only: facets_t
   use particle_points, only: points_t
   use particle_prism, only: prism_t
   use particle_voxels, only: voxels_t
   use scene_body_placement, only: count_samples
   implicit none
   private

   public :: solid_volumes_text

contains

   !> One line for each body of facets, voxels or a prism, and for each list of particles. There
   !! are no lines in axisymmetric scenes, where the volume of the shape is not that of the body.
   !! Only the part of a shape that is in the grid can be filled.
   function solid_volumes_text(grid, bodies, particles, filled) result(text)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer(int64), intent(in) :: particles(:)     !! (body) Number of particles
      real(wp), intent(in) :: filled(:)              !! (body) Volume of the particles [m3]
      character(len=:), allocatable :: text
      character(len=:), allocatable :: what
      real(wp) :: volume, inside, error
      integer :: n

      text = ""
      do n = 1, size(bodies)
         if (.not. bodies(n)%on_lattice()) then
            text = text//listed_particles_text(grid, bodies(n), particles(n))
            cycle
         end if
         if (grid%axisymmetric) cycle
         call find_volume(grid, bodies(n), what, volume)
         if (what == "") cycle
         text = text//what//" "//brief(volume)//" m3, "
         call estimate_inside(grid, bodies(n), inside, error)
         if (inside < 1.0_wp) then
            volume = inside*volume
            text = text//"about "//tenths(100.0_wp*inside)//" % of it in the grid, "
         end if
         text = text//"its particles hold "//brief(filled(n))//" m3"
         if (volume > 0.0_wp) text = text//" ("//percent(filled(n)/volume - 1.0_wp, error)//" %)"
         text = text//new_line("a")
      end do
   end function solid_volumes_text

   !> Fraction of a shape that is in the grid, exact if it is all of it, and the standard error of
   !! the fraction, from points on a lattice that are taken as random.
   subroutine estimate_inside(grid, body, inside, error)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      real(wp), intent(out) :: inside                !! [1]
      real(wp), intent(out) :: error                 !! Relative [1]
      real(wp) :: low(3), high(3)
      integer :: within, beyond

      inside = 1.0_wp
      error = 0.0_wp
      call body%shape%bounds(low, high)
      if (all(.not. grid%active .or. (low >= grid%lower .and. high <= grid%upper))) return
      call count_samples(grid, body, low, high, within, beyond)
      if (within == 0 .or. beyond == 0) return
      inside = real(within, wp)/real(within + beyond, wp)
      error = sqrt(real(beyond, wp)/(real(within, wp)*real(within + beyond, wp)))
   end subroutine estimate_inside

   !> A fraction in per cent, with its error if it has one.
   pure function percent(fraction, error) result(text)
      real(wp), intent(in) :: fraction, error        !! [1]
      character(len=:), allocatable :: text

      text = brief(100.0_wp*fraction)
      if (error > 0.0_wp) text = tenths(100.0_wp*fraction)//" +- "// &
         tenths(max(100.0_wp*error, 0.1_wp))
   end function percent

   !> A number rounded to tenths.
   pure function tenths(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text

      ! the sum is not -0
      text = brief(anint(10.0_wp*value)/10.0_wp + 0.0_wp)
   end function tenths

   !> A line for a body whose particles are not on a lattice.
   function listed_particles_text(grid, body, particles) result(text)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      integer(int64), intent(in) :: particles        !! Number of particles
      character(len=:), allocatable :: text

      text = ""
      select type (given => body%given)
      type is (disks_t)
         text = "disks      "//body%name//": "//number(particles)//" points at least "// &
            brief(given%distance*grid%spacing)//" m apart"
         if (.not. grid%axisymmetric) text = text//", "//brief(body%share)//" m3 each"
         text = text//new_line("a")
      type is (points_t)
         text = "list       "//body%name//": "//number(particles)//" of "//number(given%rows)// &
            " points of the file, which hold "//brief(given%whole_volume())//" m3"//new_line("a")
      end select
   end function listed_particles_text

   !> Volume of a shape, if it is known.
   subroutine find_volume(grid, body, what, volume)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      character(len=:), allocatable, intent(out) :: what !! Start of its line, or empty
      real(wp), intent(out) :: volume                !! [m3]
      real(wp) :: edge(3)

      what = ""
      volume = 0.0_wp
      if (.not. allocated(body%shape%shape)) return
      select type (shape => body%shape%shape)
      type is (facets_t)
         if (grid%dimensions < 3) return
         volume = abs(shape%volume())
         what = "facets     "//body%name//": "//number(size(shape%corner, 3))//" enclose"
      type is (voxels_t)
         edge = shape%edges()
         volume = real(shape%filled, wp)*grid%depth*product(merge(edge, 1.0_wp, grid%active))
         what = "voxels     "//body%name//": "//number(shape%filled)//" have"
      type is (prism_t)
         volume = shape%area()*merge(shape%height(), grid%depth, grid%dimensions == 3)
         what = "prism      "//body%name//": it has"
      end select
   end subroutine find_volume
end module run_solid_volumes
