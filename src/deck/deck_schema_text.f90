! SPDX-License-Identifier: BSD-3-Clause
!> The schema of decks as text: one key explained, all keys as a template, and messages for unknown
!! groups and keys.
module deck_schema_text
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: wp
   use base_text, only: append, buffer_t, closest, distance, join, lower, number, shared_words, &
      split, text_t
   use deck_key_rules, only: change_rule_t, find_change, may_not_change
   use deck_preset, only: preset_t
   use deck_schema, only: changes_end, changes_extent, changes_nothing, group_rule_t, key_t, &
      kind_integer, kind_logical, kind_real, kind_text, schema_t
   implicit none
   private

   public :: explain, template, unknown_group, unknown_key

   character(len=*), parameter :: newline = new_line("a")
   integer, parameter :: comment_column = 40 !! First column of comments after short lines
   integer, parameter :: longest_word = 64   !! Longer ones are compared with nothing

contains

   !> Explain a key, written as KEY or GROUP.KEY, or a group.
   subroutine explain(schema, name, text, error)
      type(schema_t), intent(in) :: schema               !! Allowed values
      character(len=*), intent(in) :: name               !! Text of the user
      character(len=:), allocatable, intent(out) :: text
      type(error_t), allocatable, intent(out) :: error   !! There is no such key
      type(text_t), allocatable :: names(:)
      type(buffer_t) :: buffer
      character(len=:), allocatable :: near, wanted
      integer :: i, k

      wanted = lower(trim(adjustl(name)))
      if (wanted /= "") then
         if (wanted(1:1) == "&") wanted = wanted(2:)
      end if
      allocate (names(0))
      do i = 1, size(schema%groups)
         associate (rule => schema%groups(i))
            call append(names, rule%name)
            if (wanted == rule%name) call explain_group(rule, buffer)
            do k = 1, size(rule%keys)
               associate (key => rule%keys(k))
                  call append(names, key%name)
                  if (wanted == key%name .or. wanted == rule%name//"."//key%name) &
                     call explain_key(rule, key, buffer)
               end associate
            end do
         end associate
      end do
      if (allocated(schema%presets)) then
         do i = 1, size(schema%presets)
            call append(names, schema%presets(i)%name)
            if (wanted == schema%presets(i)%name) call explain_preset(schema, schema%presets(i), &
               buffer)
         end do
      end if
      text = buffer%content()
      if (text /= "") return
      near = closest(wanted(index(wanted, ".") + 1:), names)
      if (near /= "") near = "; did you mean '"//near//"'?"
      call fail(error, exit_input, "no key '"//name//"'"//near//" [C116]"//newline// &
         "groups: "//join(schema%names(), " "))
   end subroutine explain

   !> A preset: its numbers and where they are from.
   subroutine explain_preset(schema, preset, buffer)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(preset_t), intent(in) :: preset
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      character(len=:), allocatable :: line
      integer :: i, rule, place

      call buffer%line("preset "//preset%name//"  "//preset%title)
      rule = schema%find(preset%group)
      do i = 1, size(preset%entries)
         associate (entry => preset%entries(i))
            line = "   "//entry%key//" = "//entry%value
            place = schema%groups(rule)%find(entry%key)
            if (place > 0) line = line//" "//schema%groups(rule)%keys(place)%unit_text
            line = line//repeat(" ", max(comment_column - len(line), 1))//entry%source
            if (size(entry%unless) > 0) line = line//"; unless "//join(entry%unless, " or ")// &
               " is given"
            if (entry%switch /= "") line = line//"; with "//entry%switch
            call buffer%line(line)
         end associate
      end do
   end subroutine explain_preset

   !> A group: its meaning, and its keys with theirs.
   subroutine explain_group(rule, buffer)
      type(group_rule_t), intent(in) :: rule
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      integer, parameter :: column = 20                  ! where the meanings begin
      integer :: i

      call buffer%add("&"//rule%name//"  "//rule%doc)
      if (rule%many) call buffer%add("; may be repeated")
      call buffer%line("")
      do i = 1, size(rule%keys)
         associate (key => rule%keys(i))
            call buffer%line("   "//key%name//repeat(" ", max(column - len(key%name), 1))//key%doc)
         end associate
      end do
   end subroutine explain_group

   !> Error message for a group that does not exist, with what was probably meant.
   function unknown_group(schema, name) result(text)
      type(schema_t), intent(in) :: schema               !! All groups
      character(len=*), intent(in) :: name               !! Text as written
      character(len=:), allocatable :: text
      integer :: i

      text = key_of_others(schema, name, errors=0)
      if (text == "") text = closest(name, schema%names())
      if (text /= "" .and. text(:1) /= ";") text = "; did you mean &"//text//"?"
      do i = 1, size(schema%groups)
         associate (rule => schema%groups(i))
            if (text == "" .and. has_all_words(name, rule%name//" "//rule%doc)) &
               text = "; did you mean &"//rule%name//" ("//rule%doc//")?"
         end associate
      end do
      if (text == "") text = "; there are: "//join(schema%names(), " ")
      text = "unknown group &"//name//text//" [D112]"
   end function unknown_group

   !> Error message for a key that does not exist, with the one that was probably meant.
   function unknown_key(schema, rule, key) result(text)
      type(schema_t), intent(in) :: schema               !! All groups
      type(group_rule_t), intent(in) :: rule             !! Group in which the key was written
      character(len=*), intent(in) :: key                !! Text as written
      character(len=:), allocatable :: text

      text = closest(key, rule%names())
      if (text /= "") text = "; did you mean '"//text//"'?"
      if (text == "") text = key_by_meaning(rule, key, least=1)
      if (text == "") text = key_of_others(schema, key, errors=0)
      if (text == "") text = key_by_meaning(rule, key, least=0)
      if (text == "") text = key_of_others(schema, key, errors=1)
      if (text == "") text = "; scree --explain "//rule%name//" lists the keys"
      text = "&"//rule%name//": unknown key '"//key//"'"//text//" [D113]"
   end function unknown_key

   !> True if a text contains all words of a word, which are joined by underscores.
   pure logical function has_all_words(word, text) result(yes)
      character(len=*), intent(in) :: word               !! Text as written
      character(len=*), intent(in) :: text               !! A name and its meaning

      yes = len(word) > 1 .and. len(word) <= longest_word
      if (yes) yes = shared_words(word, word) > 0
      if (yes) yes = shared_words(word, text) >= shared_words(word, word)
   end function has_all_words

   !> The key of a group whose name and meaning contain all words of an unknown one: most of them in
   !! the name, then the name with the fewest words. The text is empty if there is none.
   function key_by_meaning(rule, key, least) result(text)
      type(group_rule_t), intent(in) :: rule             !! Group in which the key was written
      character(len=*), intent(in) :: key                !! Text as written
      integer, intent(in) :: least                       !! Words that the name must contain
      character(len=:), allocatable :: text
      integer :: best, fewest, i, most, named, parts

      text = ""
      best = 0
      most = least
      fewest = huge(fewest)
      do i = 1, size(rule%keys)
         associate (known => rule%keys(i))
            if (.not. has_all_words(key, known%name//" "//known%doc)) cycle
            named = shared_words(key, known%name)
            parts = shared_words(known%name, known%name)
            if (named < most .or. (named == most .and. parts >= fewest)) cycle
            best = i
            most = named
            fewest = parts
         end associate
      end do
      if (best == 0) return
      text = "; did you mean '"//rule%keys(best)%name//"' ("//rule%keys(best)%doc//")?"
   end function key_by_meaning

   !> A key of other groups, with the names of these. The text is empty if there is none.
   function key_of_others(schema, key, errors) result(text)
      type(schema_t), intent(in) :: schema               !! All groups
      character(len=*), intent(in) :: key                !! Text as written
      integer, intent(in) :: errors                      !! Wrong letters in it
      character(len=:), allocatable :: text
      type(text_t), allocatable :: groups(:)
      integer, parameter :: shortest = 4                 ! word that may have a wrong letter
      character(len=:), allocatable :: found
      integer :: i, k

      text = ""
      if (len(key) > longest_word .or. (errors > 0 .and. len(key) < shortest)) return
      allocate (groups(0))
      do i = 1, size(schema%groups)
         do k = 1, size(schema%groups(i)%keys)
            associate (name => schema%groups(i)%keys(k)%name)
               if (distance(key, name) /= errors) cycle
               if (size(groups) == 0) found = name
               if (name == found) call append(groups, "&"//schema%groups(i)%name)
            end associate
         end do
      end do
      if (size(groups) > 0) text = "; did you mean '"//found//"' of "//join(groups, " or ")//"?"
   end function key_of_others

   !> A key: kind, unit, range, default, words, conditions.
   subroutine explain_key(rule, key, buffer)
      type(group_rule_t), intent(in) :: rule             !! Its group
      type(key_t), intent(in) :: key
      type(buffer_t), intent(inout) :: buffer            !! Extended by the text
      character(len=:), allocatable :: note
      integer :: i

      call buffer%line(key%group//"."//key%name//"  "//key%doc)
      call buffer%line("   kind: "//kind_of(key))
      note = ""
      if (any(abs(key%unit%power(:3)) > 0.0_wp)) note = ", or that of &units system"
      if (key%unit_text /= "") call buffer%line("   unit: "//key%unit_text//note)
      if (key%range%text /= "") call buffer%line("   range: "//key%range%text)
      if (size(key%words) > 0) call buffer%line("   one of: "//join(key%words, " "))
      if (key%target /= "") call buffer%line("   refers to: name of &"//key%target)
      if (allocated(key%default)) then
         call buffer%line("   default: "//literal(key))
      else if (key%required) then
         call buffer%line("   must be given")
      else
         call buffer%line("   default: none")
      end if
      do i = 1, size(key%owners)
         associate (owner => key%owners(i))
            if (size(owner%words) == 0) then
               call buffer%line("   needs: &"//owner%group//" "//owner%key//" = .true.")
            else
               call buffer%line("   needs: &"//owner%group//" "//owner%key//" = '"// &
                  join(owner%words, "' or '")//"'")
            end if
         end associate
      end do
      call buffer%line("   restart: "//restart_note(rule, key))
   end subroutine explain_key

   !> Whether a restart may change a key, and what follows.
   pure function restart_note(rule, key) result(note)
      type(group_rule_t), intent(in) :: rule             !! Its group
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: note
      type(change_rule_t) :: change
      integer :: n

      call find_change(rule%changes, key%name, key%kind == kind_real, rule%names(), change)
      select case (change%meaning)
      case (may_not_change)
         note = "must not change; "//change%why
      case (changes_nothing)
         note = "may change; no result depends on it"
      case (changes_extent)
         note = "may change, with outputs or limits of the run"
      case (changes_end)
         note = "may change, with the end of the run"
      case default
         note = "may change, with the rest of the run"
      end select
      do n = 1, size(rule%changes)
         if (rule%changes(n)%key /= key%name .or. len(rule%changes(n)%without) == 0) cycle
         note = note//"; without "//rule%changes(n)%without//" it must not change, as "// &
            rule%changes(n)%why
      end do
   end function restart_note

   !> Kind and number of values of a key.
   pure function kind_of(key) result(text)
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: text
      character(len=14) :: one

      select case (key%kind)
      case (kind_real)
         one = "number"
      case (kind_integer)
         one = "integer"
      case (kind_logical)
         one = ".true./.false."
      case default
         one = "text"
      end select
      text = trim(one)
      if (key%number_of_values > 1 .and. key%exact) text = &
         number(key%number_of_values)//" "//text//"s"
      if (.not. key%exact) text = "up to "//number(key%number_of_values)//" "//text//"s"
   end function kind_of

   !> Default of a key as written in a deck.
   function literal(key) result(text)
      type(key_t), intent(in) :: key                     !! The key, with a default
      character(len=:), allocatable :: text
      type(text_t), allocatable :: words(:)

      text = key%default
      if (key%kind /= kind_text) return
      allocate (words(0))
      if (key%number_of_values > 1) call split(key%default, words)
      if (key%number_of_values > 1) text = join(words, "', '")
      text = "'"//text//"'"
   end function literal

   !> A deck with all keys: defaults as values, other keys as comments.
   function template(schema) result(text)
      type(schema_t), intent(in) :: schema               !! Allowed values
      character(len=:), allocatable :: text
      type(buffer_t) :: buffer
      integer :: i, k

      call buffer%line("! All groups and keys. Numbers are in SI; see &units. Lines with ! in "// &
         "front have no default")
      call buffer%line("! or belong to a choice that is not the default; those marked * must "// &
         "be given.")
      do i = 1, size(schema%groups)
         associate (rule => schema%groups(i))
            if (rule%name == "include") then
               call buffer%line("! &include file = 'name.nml' /    "//rule%doc)
               cycle
            else if (rule%name == "define") then
               call buffer%line("! &define name = 1.0 /             "//rule%doc)
               cycle
            end if
            call buffer%line("")
            call buffer%line("! "//rule%doc)
            if (rule%many) then
               call buffer%line("! &"//rule%name//"               ! may be repeated")
            else
               call buffer%line("&"//rule%name)
            end if
            do k = 1, size(rule%keys)
               call buffer%line(template_line(schema, rule, rule%keys(k)))
            end do
            if (rule%many) call buffer%add("! ")
            call buffer%line("/")
         end associate
      end do
      text = buffer%content()
   end function template

   !> One key of the template.
   function template_line(schema, rule, key) result(line)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(group_rule_t), intent(in) :: rule             !! Its group
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: line
      logical :: active

      active = allocated(key%default) .and. .not. rule%many
      if (active) active = holds_by_default(schema, key)
      line = "!  "
      if (active) line = "   "
      line = line//key%name//" ="
      if (allocated(key%default)) line = line//" "//literal(key)
      line = line//repeat(" ", max(comment_column - len(line), 1))//"! "
      if (key%required) line = line//"* "
      line = line//kind_of(key)
      if (key%unit_text /= "") line = line//" ["//key%unit_text//"]"
      if (key%range%text /= "") line = line//" "//key%range%text
      line = line//": "//key%doc
      if (size(key%words) > 0) line = line//" {"//join(key%words, "|")//"}"
   end function template_line

   !> True if the conditions of a key hold in a deck of defaults.
   logical function holds_by_default(schema, key) result(holds)
      type(schema_t), intent(in) :: schema               !! Allowed values
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: default
      integer :: i, k, owner, rule
      logical :: found

      holds = .true.
      do i = 1, size(key%owners)
         associate (condition => key%owners(i))
            rule = schema%find(condition%group)
            owner = schema%groups(rule)%find(condition%key)
            default = ""
            if (allocated(schema%groups(rule)%keys(owner)%default)) &
               default = schema%groups(rule)%keys(owner)%default
            found = size(condition%words) == 0 .and. default == ".true."
            do k = 1, size(condition%words)
               found = found .or. condition%words(k)%text == default
            end do
            holds = holds .and. found
         end associate
      end do
   end function holds_by_default
end module deck_schema_text
