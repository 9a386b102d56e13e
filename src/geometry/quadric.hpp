// Quadric error metric (Garland and Heckbert 1997): weighted sums of squared distances to planes.
#pragma once

#include "geometry/vector.hpp"

namespace colossus::geometry {

// x^T A x + 2 b^T x + c with symmetric A.
struct Quadric {
  double xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, xz = 0.0, yz = 0.0;
  double bx = 0.0, by = 0.0, bz = 0.0;
  double c = 0.0;

  // Adds the plane through `point` with unit normal `n`.
  void add_plane(const Vec3& n, const Vec3& point, double weight) {
    const double d = -dot(n, point);
    xx += weight * n.x * n.x;
    yy += weight * n.y * n.y;
    zz += weight * n.z * n.z;
    xy += weight * n.x * n.y;
    xz += weight * n.x * n.z;
    yz += weight * n.y * n.z;
    bx += weight * n.x * d;
    by += weight * n.y * d;
    bz += weight * n.z * d;
    c += weight * d * d;
  }

  void add(const Quadric& q) {
    xx += q.xx;
    yy += q.yy;
    zz += q.zz;
    xy += q.xy;
    xz += q.xz;
    yz += q.yz;
    bx += q.bx;
    by += q.by;
    bz += q.bz;
    c += q.c;
  }

  // Never negative: rounding below zero counts as zero.
  double at(const Vec3& p) const {
    const double rx = xx * p.x + 2.0 * (xy * p.y + xz * p.z + bx);
    const double ry = yy * p.y + 2.0 * (yz * p.z + by);
    const double rz = zz * p.z + 2.0 * bz;
    const double value = p.x * rx + p.y * ry + p.z * rz + c;
    return value > 0.0 ? value : 0.0;
  }

  // The point that minimises this quadric plus a weak pull towards `anchor`, which decides where it is flat.
  Vec3 minimum(const Vec3& anchor) const {
    const double pull = 1e-3 * (xx + yy + zz) + 1e-300;
    const double a = xx + pull;
    const double e = yy + pull;
    const double i = zz + pull;
    const double rx = pull * anchor.x - bx;
    const double ry = pull * anchor.y - by;
    const double rz = pull * anchor.z - bz;
    // Cofactors of the symmetric matrix (a xy xz; xy e yz; xz yz i), positive definite thanks to the pull.
    const double c0 = e * i - yz * yz;
    const double c1 = xz * yz - xy * i;
    const double c2 = xy * yz - e * xz;
    const double determinant = a * c0 + xy * c1 + xz * c2;
    if (!(determinant > 0.0)) return anchor;
    const double c4 = a * i - xz * xz;
    const double c5 = xy * xz - a * yz;
    const double c8 = a * e - xy * xy;
    return {(c0 * rx + c1 * ry + c2 * rz) / determinant, (c1 * rx + c4 * ry + c5 * rz) / determinant,
            (c2 * rx + c5 * ry + c8 * rz) / determinant};
  }
};

}  // namespace colossus::geometry
