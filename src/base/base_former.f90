! SPDX-License-Identifier: BSD-3-Clause
!> Former names: keys and words that decks were written with and that are called otherwise now.
!!
!! Who owns a key declares what it was called. The reader of decks tells the new name from it, and
!! the list of the program, which `scree-deck migrate` follows, is the same table as text.
module base_former
   use base_text, only: buffer_t, join, lower, number, split, text_t
   implicit none
   private

   public :: find_former, former_line, former_t, make_former, tell_former

   !> A key, or some words of one, that decks do not use any more.
   type :: former_t
      character(len=:), allocatable :: key               !! The key
      type(text_t), allocatable :: words(:)              !! Values that are meant; empty: all
      !> New name, or new key with its word; empty: it can go; not allocated: somebody must decide.
      character(len=:), allocatable :: becomes
      character(len=:), allocatable :: doc               !! Why, and what takes its place, or empty
      integer :: since = 1                               !! deck_version that brought the new name
      logical :: holds = .false.                         !! It says what is always so
   end type former_t

contains

   !> Make an entry.
   pure function make_former(old, becomes, doc, since, holds) result(former)
      character(len=*), intent(in) :: old                !! A key, or key = word word
      character(len=*), intent(in), optional :: becomes  !! New key, key = word, or blank: none
      character(len=*), intent(in), optional :: doc      !! Why, and what takes its place
      integer, intent(in), optional :: since             !! deck_version that brought the new name
      logical, intent(in), optional :: holds             !! It says what is always so
      type(former_t) :: former
      integer :: equals

      equals = index(old//"=", "=")
      former%key = trim(old(:equals - 1))
      call split(old(equals + 1:), former%words)
      if (present(becomes)) former%becomes = becomes
      former%doc = ""
      if (present(doc)) former%doc = doc
      if (present(since)) former%since = since
      if (present(holds)) former%holds = holds
   end function make_former

   !> Index of the first entry that fits a key and its value, 0 if none does.
   pure integer function find_former(formers, key, value) result(place)
      type(former_t), intent(in) :: formers(:)           !! Former names of a group
      character(len=*), intent(in) :: key                !! As in the deck, small letters
      character(len=*), intent(in) :: value              !! As in the deck, quotes and all
      integer :: word

      do place = 1, size(formers)
         if (formers(place)%key /= key) cycle
         if (size(formers(place)%words) == 0) return
         do word = 1, size(formers(place)%words)
            if (plain(formers(place)%words(word)%text) == plain(value)) return
         end do
      end do
      place = 0
   end function find_former

   !> A value without quotes, in small letters, switches in one spelling.
   pure function plain(value) result(text)
      character(len=*), intent(in) :: value              !! As in the deck
      character(len=:), allocatable :: text

      text = lower(trim(adjustl(value)))
      if (len(text) > 1) then
         if (scan(text(1:1), "'""") == 1) text = trim(adjustl(text(2:len(text) - 1)))
      end if
      select case (text)
      case (".t.", "true", "t")
         text = ".true."
      case (".f.", "false", "f")
         text = ".false."
      case default
         continue
      end select
   end function plain

   !> What to say of a former name in a deck.
   pure function tell_former(former, group, value, file) result(text)
      type(former_t), intent(in) :: former               !! The entry
      character(len=*), intent(in) :: group              !! Its group, without &
      character(len=*), intent(in) :: value              !! As in the deck, may be empty
      character(len=*), intent(in) :: file               !! The deck, empty: the command line
      character(len=:), allocatable :: text

      text = "&"//group//": key '"//former%key//"'"
      if (size(former%words) > 0) text = "&"//group//": "//former%key//" = "//value
      if (.not. allocated(former%becomes)) then
         text = text//" is gone"//since_when(former)//": "//former%doc
         return
      end if
      if (former%holds) then
         text = text//trim(merge(" is always so", " does nothing", size(former%words) > 0))// &
            since_when(former)//": "//former%doc//"; it can go"
      else if (former%becomes == "") then
         text = text//" is gone"//since_when(former)//": "//former%doc//"; remove it"
      else if (size(former%words) > 0) then
         text = text//" is called "//quoted(former%becomes)//since_when(former)//": write that"
      else
         text = text//" is called '"//former%becomes//"'"//since_when(former)//": write "// &
            former%becomes//" = "//value
      end if
      if (file /= "") text = text//", or run scree-deck migrate "//file
   end function tell_former

   !> Since which format of decks, unless it is the first.
   pure function since_when(former) result(text)
      type(former_t), intent(in) :: former               !! The entry
      character(len=:), allocatable :: text

      text = ""
      if (former%since > 1) text = " since deck_version "//number(former%since)
   end function since_when

   !> A key = word with quotes around a text; switches and keys alone stay as they are.
   pure function quoted(becomes) result(text)
      character(len=*), intent(in) :: becomes            !! As declared
      character(len=:), allocatable :: text
      integer :: equals

      text = becomes
      equals = index(becomes, "=")
      if (equals == 0 .or. index(becomes, "= .") > 0) return
      text = becomes(:equals)//" '"//trim(adjustl(becomes(equals + 1:)))//"'"
   end function quoted

   !> An entry as a line of the list: GROUP.KEY = 'WORD' -> NEW; since deck_version N  ! why.
   function former_line(group, former) result(line)
      character(len=*), intent(in) :: group              !! Its group, without &
      type(former_t), intent(in) :: former               !! The entry
      character(len=:), allocatable :: line
      type(buffer_t) :: buffer

      call buffer%add(group//"."//former%key)
      if (size(former%words) > 0) call buffer%add(" = '"//join(former%words, "' '")//"'")
      call buffer%add(" -> ")
      if (.not. allocated(former%becomes)) then
         call buffer%add("by hand")
      else if (former%becomes == "") then
         call buffer%add("gone")
      else
         call buffer%add(quoted(former%becomes))
      end if
      if (former%since > 1) call buffer%add("; since deck_version "//number(former%since))
      if (former%doc /= "") call buffer%add("  ! "//former%doc)
      line = buffer%content()
   end function former_line
end module base_former
