! SPDX-License-Identifier: BSD-3-Clause
!> The group &contact: its keys, bodies with a common velocity field, and the laws between them.
module scene_contact
   use base_kinds, only: wp
   use base_text, only: brief, number, text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, schema_t
   use material_type, only: material_t
   use particle_body, only: body_t
   use particle_store, only: store_t
   use step_contact, only: dissipation_after_remap
   use step_method, only: position_of
   use step_node_fields, only: node_needs_t, node_tally_t, nodes_t
   use step_simulation, only: contact_t, simulation_t, velocity_field_t
   use transfer_contact, only: contact_bonded, contact_friction, contact_names, pair_law_t
   implicit none
   private

   public :: bond_stores, contact_columns, contact_text, declare_contact, read_contact, store_name

   integer, parameter, public :: most_fields = 8     !! Their pairs grow as the square
   character(len=1), parameter :: any_body = "*"     !! Matches every body

contains

   !> Declare &contact.
   subroutine declare_contact(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("contact", &
         "contact law of a pair of bodies; pairs without a law slide without friction", many=.true.)
      call schema%text("contact", "bodies(:2)", "names of the two bodies, '*' for any body; "// &
         "names take precedence over '*'; the same name twice: contact between parts of a "// &
         "body that failed material separates", default="*", owner="effects.contact")
      call schema%text("contact", "law", "friction: Coulomb; stick: no slip while pressed "// &
         "together; bonded: no relative motion until the bond breaks, then friction", &
         default="friction", words="friction stick frictionless bonded", owner="effects.contact")
      call schema%real("contact", "friction", "friction coefficient", default="0.0", range=">= 0", &
         owner="effects.contact & law = friction bonded")
      call schema%real("contact", "bond_strength", "strength of the bond, for tension and "// &
         "shear combined; without it the bond does not break", unit="Pa", range="> 0", &
         owner="effects.contact & law = bonded")
      call schema%refer("contact", "bodies", "body")
      call schema%allow_change("contact", "#", changes_physics)
      call schema%forbid_change("contact", "bodies law + -", "the bonds of the particles of "// &
         "the checkpoint belong to this law and pair")
   end subroutine declare_contact

   !> Assign velocity fields to the bodies and stores to the fields, if contact is on.
   subroutine read_contact(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Materials are known
      type(body_t), intent(inout) :: bodies(:)       !! Get their stores
      type(contact_t), allocatable :: contact
      type(group_t) :: group
      logical, allocatable :: parting(:)
      logical :: acts

      group = deck%group("effects", 1)
      call group%get("contact", acts)
      if (.not. acts) return
      allocate (contact)
      call number_fields(deck, contact%field_of_body)
      call find_parting(deck, bodies, contact%field_of_body, parting)
      associate (fields => maxval(contact%field_of_body) + count(parting))
         if (fields > most_fields) then
            call deck%add_error(group, "contact = .true. allows at most "//number(most_fields)// &
               " velocity fields, and the bodies have "//number(fields)// &
               ", two for a body with self-contact; give bodies that need no contact with "// &
               "each other the same field in &body [D339]", &
               "contact")
            return
         end if
         call refuse_others(deck, group, simulation)
         allocate (simulation%fields(fields), contact%law(fields, fields))
      end associate
      call pair_sides(simulation, parting)
      call assign_stores(contact, simulation, bodies)
      call read_pairs(deck, bodies, contact)
      if (any(parting)) call share_laws(simulation%fields, contact)
      if (any(parting)) call refuse_parting(deck, simulation, bodies, contact)
      call move_alloc(contact, simulation%effects%contact)
   end subroutine read_contact

   !> Number the velocity fields in the order of the bodies.
   subroutine number_fields(deck, field)
      type(deck_t), intent(in) :: deck
      integer, allocatable, intent(out) :: field(:)  !! (body) From 1
      type(group_t) :: group
      integer :: request(deck%count("body")), body, earlier, fields

      allocate (field(size(request)))
      fields = 0
      do body = 1, size(request)
         group = deck%group("body", body)
         call group%get("field", request(body))
         field(body) = 0
         do earlier = 1, body - 1
            if (request(body) > 0 .and. request(earlier) == request(body)) field(body) = &
               field(earlier)
         end do
         if (field(body) > 0) cycle
         fields = fields + 1
         field(body) = fields
      end do
   end subroutine number_fields

   !> Velocity fields of bodies that have contact with themselves.
   subroutine find_parting(deck, bodies, field_of_body, parting)
      type(deck_t), intent(in) :: deck
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: field_of_body(:)        !! (body)
      logical, allocatable, intent(out) :: parting(:) !! (field)
      type(text_t), allocatable :: names(:)
      integer :: index, place

      allocate (parting(maxval(field_of_body)), source=.false.)
      do index = 1, deck%count("contact")
         call names_of(deck%group("contact", index), names)
         if (names(1)%text /= names(2)%text) cycle
         place = place_of(names(1)%text, bodies)
         if (place > 0) parting(field_of_body(place)) = .true.
      end do
   end subroutine find_parting

   !> Add a velocity field for the second side of each body with self-contact, after all fields of
   !! bodies.
   subroutine pair_sides(simulation, parting)
      type(simulation_t), intent(inout) :: simulation !! Its velocity fields are new
      logical, intent(in) :: parting(:)              !! (field of bodies)
      integer :: field, last

      last = size(parting)
      do field = 1, size(parting)
         if (.not. parting(field)) cycle
         last = last + 1
         simulation%fields(field)%other = last
         simulation%fields(last)%other = field
         allocate (simulation%fields(field)%sides)
      end do
   end subroutine pair_sides

   !> Both sides of a velocity field have the contact laws of this field with others. Between the
   !! sides the law of the body with itself applies.
   pure subroutine share_laws(fields, contact)
      type(velocity_field_t), intent(in) :: fields(:)
      type(contact_t), intent(inout) :: contact      !! Laws of the fields of bodies are known
      integer :: source(size(fields)), n

      do n = 1, size(fields)
         source(n) = n
         if (fields(n)%other > 0 .and. .not. allocated(fields(n)%sides)) source(n) = &
            fields(n)%other
      end do
      contact%law = contact%law(source, source)
   end subroutine share_laws

   !> Check settings that self-contact excludes.
   subroutine refuse_parting(deck, simulation, bodies, contact)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Materials and method are known
      type(body_t), intent(in) :: bodies(:)
      type(contact_t), intent(in) :: contact         !! Laws are known
      type(text_t), allocatable :: names(:)
      type(group_t) :: group
      integer :: index, place, body, field

      do index = 1, deck%count("contact")
         group = deck%group("contact", index)
         call names_of(group, names)
         place = place_of(names(1)%text, bodies)
         if (names(1)%text /= names(2)%text .or. place == 0) cycle
         field = contact%field_of_body(place)
         if (.not. any([(fails(body), body=1, size(bodies))])) call deck%add_error(group, &
            "no material can fail in body '"//bodies(place)%name//"', so it has no contact "// &
            "with itself; give its material a damage_model or spall, with &effects damage = "// &
            ".true. [D336]", &
            "bodies")
         call refuse_method(deck, group, simulation, &
            any(contact%law(field, :)%kind == contact_bonded))
      end do

   contains

      !> Can the material of a body of the same velocity field fail?
      logical function fails(body) result(can)
         integer, intent(in) :: body                 !! Index of the body

         can = contact%field_of_body(body) == field
         if (can) can = allocated(simulation%materials(bodies(body)%store)%failure%fracture)
      end function fails
   end subroutine refuse_parting

   !> Refuse methods that allow only one velocity of a body at a node.
   subroutine refuse_method(deck, group, simulation, bonded)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! &contact
      type(simulation_t), intent(in) :: simulation   !! Materials and method are known
      logical, intent(in) :: bonded                  !! Has the body a bond?
      character(len=:), allocatable :: basis, quadrature, transfer, what
      type(group_t) :: method

      method = deck%group("method", 1)
      call method%get("basis", basis)
      call method%get("transfer", transfer)
      call method%get("quadrature", quadrature)
      what = ""
      if (simulation%scheme%method%transfer%filters()) what = "transfer = '"//transfer// &
         "'; use 'flip', 'rflip' or 'aflip'"
      if (simulation%scheme%method%remaps()) what = "strain of velocities that are mapped "// &
         "twice; use stress_update = 'usl' or 'usf'"
      if (.not. simulation%scheme%method%basis%is_linear()) what = "basis = '"// &
         basis//"'; use 'linear'"
      if (simulation%scheme%method%dual) then
         if (.not. simulation%scheme%method%quadrature%is_plain()) what = "quadrature = '"// &
            quadrature//"'; use 'point'"
      end if
      if (allocated(simulation%scheme%normalises)) &
         what = "normalised sums; use normalise = 'none'"
      if (simulation%scheme%method%even) what = "antilock = 'bbar'; remove it"
      if (simulation%scheme%repacks) what = "volume_from = 'grid'; remove it"
      if (deck%count("load") > 0) what = "&load; remove it"
      if (bonded) what = "law = 'bonded' for that body; use another law"
      if (what /= "") call deck%add_error(group, &
         "contact of a body with itself cannot be combined with "//what//" [D336]", "bodies")
   end subroutine refuse_method

   !> Check settings that contact excludes.
   subroutine refuse_others(deck, group, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! &effects
      type(simulation_t), intent(in) :: simulation   !! Materials are known
      type(group_t) :: exact
      character(len=:), allocatable :: solution
      integer :: n

      exact = deck%group("exact")
      call exact%get("solution", solution)
      if (solution /= "none") call deck%add_error(group, &
         "contact = .true. cannot be combined with &exact, whose solutions are for one body; "// &
         "remove one of the two [D340]", &
         "contact")
      do n = 1, size(simulation%materials)
         if (.not. allocated(simulation%materials(n)%heat)) cycle
         if (.not. simulation%materials(n)%heat%conductivity > 0.0_wp) cycle
         call deck%add_error(group, "contact = .true. cannot be combined with the "// &
            "conductivity of material '"//simulation%materials(n)%name//"', because heat "// &
            "would cross gaps; remove one of the two [D346]", "contact")
         return
      end do
   end subroutine refuse_others

   !> Assign a separate store to each pair of velocity field and material; the stores of a field are
   !! consecutive.
   subroutine assign_stores(contact, simulation, bodies)
      type(contact_t), intent(inout) :: contact      !! Gets the stores of its fields
      type(simulation_t), intent(inout) :: simulation !! In the end one material a store
      type(body_t), intent(inout) :: bodies(:)       !! Get their stores
      integer :: kind(size(bodies)), owner(size(bodies)), field, material, body, stores

      owner = bodies%store
      stores = 0
      do field = 1, size(simulation%fields)
         simulation%fields(field)%first_store = stores + 1
         do material = 1, size(simulation%materials)
            if (.not. any(contact%field_of_body == field .and. owner == material)) cycle
            stores = stores + 1
            kind(stores) = material
            do body = 1, size(bodies)
               if (contact%field_of_body(body) == field .and. owner(body) == material) &
                  bodies(body)%store = stores
            end do
         end do
         simulation%fields(field)%last_store = stores
      end do
      simulation%materials = simulation%materials(kind(:stores))
      contact%material = kind(:stores)
   end subroutine assign_stores

   !> Laws between bodies; names take precedence over '*'.
   subroutine read_pairs(deck, bodies, contact)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(body_t), intent(in) :: bodies(:)
      type(contact_t), intent(inout) :: contact      !! Gets the laws
      type(text_t), allocatable :: names(:)
      type(pair_law_t) :: law
      type(group_t) :: group
      integer :: owner(size(contact%law, 1), size(contact%law, 1)), wild, index, one, other, i, j

      owner = 0
      ! pairs with two '*' are overridden by pairs with one, and these by pairs of names
      do wild = 2, 0, -1
         do index = 1, deck%count("contact")
            group = deck%group("contact", index)
            call names_of(group, names)
            if (wild_cards(names) /= wild) cycle
            call read_law(group, law)
            one = place_of(names(1)%text, bodies)
            other = place_of(names(2)%text, bodies)
            if (wild == 0) call check_pair(deck, group, contact%field_of_body, one, other)
            do i = 1, size(bodies)
               do j = 1, size(bodies)
                  if (one > 0 .and. one /= i .or. other > 0 .and. other /= j) cycle
                  call set_law(contact%field_of_body(i), contact%field_of_body(j), index)
               end do
            end do
         end do
      end do
      contact%bonded = any(contact%law%kind == contact_bonded)

   contains

      !> Set the law of two fields, in both orders, unless another group of the same precedence did.
      subroutine set_law(a, b, index)
         integer, intent(in) :: a, b                 !! Indices of two velocity fields
         integer, intent(in) :: index                !! Index of the group
         type(group_t) :: earlier
         type(text_t), allocatable :: before(:)

         if (a == b .and. .not. (wild == 0 .and. one == other)) return
         if (owner(a, b) == index) return
         if (owner(a, b) > 0) then
            earlier = deck%group("contact", owner(a, b))
            call names_of(earlier, before)
            if (wild_cards(before) == wild) then
               call deck%add_error(group, "bodies of velocity fields "//number(min(a, b))// &
                  " and "//number(max(a, b))//" already have a law, in line "// &
                  number(earlier%line("bodies"))//"; remove one of the two [D338]", "bodies")
               return
            end if
         end if
         owner(a, b) = index
         owner(b, a) = index
         contact%law(a, b) = law
         contact%law(b, a) = law
      end subroutine set_law
   end subroutine read_pairs

   !> The two names of a group; a missing one matches any body.
   subroutine names_of(group, names)
      type(group_t), intent(in) :: group             !! &contact
      type(text_t), allocatable, intent(out) :: names(:) !! Two
      type(text_t), allocatable :: given(:)
      integer :: n

      call group%list("bodies", given)
      allocate (names(2))
      do n = 1, 2
         names(n)%text = any_body
         if (n <= size(given)) names(n)%text = given(n)%text
      end do
   end subroutine names_of

   !> Number of names, of two, that match any body.
   pure integer function wild_cards(names) result(wild)
      type(text_t), intent(in) :: names(2)

      wild = merge(1, 0, names(1)%text == any_body) + merge(1, 0, names(2)%text == any_body)
   end function wild_cards

   !> Index of a body, 0 = any.
   pure integer function place_of(name, bodies) result(place)
      character(len=*), intent(in) :: name           !! Or '*'
      type(body_t), intent(in) :: bodies(:)

      do place = size(bodies), 1, -1
         if (bodies(place)%name == name) return
      end do
   end function place_of

   !> The law of a group.
   subroutine read_law(group, law)
      type(group_t), intent(in) :: group             !! &contact
      type(pair_law_t), intent(out) :: law           !! Contact law from the deck
      character(len=:), allocatable :: word

      call group%get("law", word)
      law%kind = max(position_of(word, contact_names), contact_friction)
      if (law%kind == contact_friction .or. law%kind == contact_bonded) &
         call group%get("friction", law%friction)
      if (law%kind == contact_bonded .and. group%given("bond_strength")) &
         call group%get("bond_strength", law%strength)
   end subroutine read_law

   !> Refuse contact between bodies with a common velocity field.
   subroutine check_pair(deck, group, field_of_body, one, other)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! &contact
      integer, intent(in) :: field_of_body(:)        !! (body)
      integer, intent(in) :: one, other              !! Indices of two bodies

      if (one == other) return
      if (field_of_body(one) == field_of_body(other)) then
         call deck%add_error(group, "the two bodies share a velocity field, so they move as "// &
            "one; give them different values of field in &body [D337]", "bodies")
      end if
   end subroutine check_pair

   !> Allocate the bond state of the particles whose velocity fields have a bond.
   subroutine bond_stores(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run with contact; empty stores
      integer :: field, index

      do field = 1, size(simulation%fields)
         if (.not. any(simulation%effects%contact%law(field, :)%kind == contact_bonded)) cycle
         do index = simulation%fields(field)%first_store, simulation%fields(field)%last_store
            allocate (simulation%stores(index)%bond(0))
         end do
      end do
   end subroutine bond_stores

   !> Name of a store: that of its material, followed by a number if several stores have it.
   pure function store_name(materials, index) result(name)
      type(material_t), intent(in) :: materials(:)   !! One per store
      integer, intent(in) :: index                   !! Index of the store
      character(len=:), allocatable :: name
      integer :: earlier, same

      same = 1
      do earlier = 1, index - 1
         if (materials(earlier)%name == materials(index)%name) same = same + 1
      end do
      name = materials(index)%name
      if (same > 1) name = name//"@"//number(same)
   end function store_name

   !> Columns of node fields that contact needs in addition to those of each velocity field.
   pure integer function contact_columns(contact, pressed) result(columns)
      type(contact_t), intent(in) :: contact
      logical, intent(in) :: pressed !! True if contact forces are stored for their work

      type(node_tally_t) :: tally
      type(nodes_t) :: nodes
      integer :: field

      tally%nodes = 1
      call contact%count(tally)
      do field = 1, size(contact%law, 1)
         call nodes%work%count(node_needs_t(contact=merge(4, 1, pressed)), tally)
      end do
      columns = int(tally%needed)
   end function contact_columns

   !> Lines of `--check`: the velocity fields, the pairs and their cost.
   function contact_text(simulation, bodies) result(text)
      type(simulation_t), intent(in) :: simulation   !! The run with contact
      type(body_t), intent(in) :: bodies(:)
      character(len=:), allocatable :: text
      integer :: a, b

      associate (contact => simulation%effects%contact)
         text = "contact    "//number(size(contact%law, 1))//" velocity fields, each with node "// &
            "fields and an exchange of its own, and "//number(contact_columns(contact, &
            dissipation_after_remap(simulation%scheme)))// &
            " numbers a node"//new_line("a")
         do b = 2, size(contact%law, 1)
            do a = 1, b - 1
               if (members(contact, bodies, b) == "") cycle
               text = text//"           "//members(contact, bodies, a)//" - "// &
                  members(contact, bodies, b)//": "//law_text(contact%law(a, b))//new_line("a")
            end do
         end do
         do a = 1, size(contact%law, 1)
            if (.not. allocated(simulation%fields(a)%sides)) cycle
            text = text//"           parts of "//members(contact, bodies, a)// &
               ", where failed material separates them: "//law_text(contact%law(a, a))// &
               new_line("a")
         end do
      end associate
   end function contact_text

   !> Names of the bodies of a field.
   pure function members(contact, bodies, field) result(text)
      type(contact_t), intent(in) :: contact
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: field                   !! Index of the velocity field
      character(len=:), allocatable :: text
      integer :: body

      text = ""
      do body = 1, size(bodies)
         if (contact%field_of_body(body) /= field) cycle
         if (text /= "") text = text//" + "
         text = text//bodies(body)%name
      end do
   end function members

   !> A law in words.
   function law_text(law) result(text)
      type(pair_law_t), intent(in) :: law            !! Between two fields
      character(len=:), allocatable :: text

      text = trim(contact_names(law%kind))
      if (law%kind == contact_friction) text = text//" "//brief(law%friction)
      if (law%kind == contact_bonded .and. law%strength < huge(1.0_wp)) &
         text = text//" up to "//brief(law%strength)//" Pa"
   end function law_text
end module scene_contact
