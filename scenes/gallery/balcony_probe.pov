// Renders POV-Ray's balcony example from the position of the chair, as a lat-long image in the frame of
// balcony.toml: its +y is +z here; its (x, y, z) is (x, -z, y) here.
// povray +Ibalcony_probe.pov +Obalcony_probe.exr +FE +W512 +H256 -A +L<folder of balcony.pov>
#include "balcony.pov"

#declare Place = <2.95, 1.9, 0.5>;

// A light_source is not visible to cameras. This sphere inside the sky sends as much light to the position:
// radiance = pi * colour / solid angle.
#declare Towards_Sun = vnormalize(<3.0, -2.5, 2.6>);
#declare Sun_Radius = 0.04;  // in radians
sphere {
  Place + 20 * Towards_Sun, 20 * Sun_Radius
  pigment { rgb <3.43, 2.87, 1.95> / (Sun_Radius * Sun_Radius) }
  finish { emission 1 ambient 0 diffuse 0 }
  no_shadow
}

// POV-Ray uses the last camera of a scene.
camera {
  spherical
  location Place
  direction -y
  up -z  // these two mirror the image as right-handed lat-long images are
  right x
  angle 360 180
}
