// What POV-Ray's balcony example looks like from the place where the chair will stand, as a lat-long image in
// the frame of balcony.toml: +y up there is +z up here, (x, y, z) there is (x, -z, y) here.
// povray +Ibalcony_probe.pov +Obalcony_probe.exr +FE +W512 +H256 -A +L<folder of balcony.pov>
#include "balcony.pov"

#declare Place = <2.95, 1.9, 0.5>;

// A light_source cannot be seen. This ball, within the walls of the sky, sends as much light to the place:
// radiance = pi * colour / solid angle.
#declare Towards_Sun = vnormalize(<3.0, -2.5, 2.6>);
#declare Sun_Radius = 0.04;  // in radians
sphere {
  Place + 20 * Towards_Sun, 20 * Sun_Radius
  pigment { rgb <3.43, 2.87, 1.95> / (Sun_Radius * Sun_Radius) }
  finish { emission 1 ambient 0 diffuse 0 }
  no_shadow
}

// The last camera is the one that counts.
camera {
  spherical
  location Place
  direction -y
  up -z  // these two mirror the image as right-handed lat-long images are
  right x
  angle 360 180
}
