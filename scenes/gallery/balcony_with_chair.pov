// POV-Ray's balcony example, untouched, with a baked chair in it.
// povray +Ibalcony_with_chair.pov +W640 +H480 +A0.3 -J +L<folder of balcony.pov> +L<folder of balcony_Chair.inc>
#include "balcony.pov"
#include "balcony_Chair.inc"
object {
  Balcony_Chair
  rotate 90 * x                // +y up becomes +z up
  translate <2.95, 1.9, 0>
}
