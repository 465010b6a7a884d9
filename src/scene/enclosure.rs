//! What a bound knows of a patch without looking at it: second-derivative enclosures and normal cones.

use super::{Enclosure, NormalCone};
use crate::geometry::Net;
use crate::geometry::bernstein::{Bernstein, second_derivative_sets};
use glam::DVec3;

/// Signed boxes and radii of S_uu, S_uv, S_vv, from the quarters of the patch: 1.01 to 1.09 times the truth where the
/// undivided sets give 1.14 to 1.97 (research "tessellation-bounds", section 2).
pub fn enclose(net: Net) -> Enclosure {
    let mut out = Enclosure { low: [DVec3::INFINITY; 3], high: [DVec3::NEG_INFINITY; 3], radius: [0.0; 3] };
    for quarter in net.split(0, 0.5).iter().flat_map(|half| half.net().split(1, 0.5)) {
        for (k, set) in second_derivative_sets(quarter.net()).into_iter().enumerate() {
            for s in set {
                // Half the parameter range in both directions: second derivatives by the parent's are four times these.
                let s = s * 4.0;
                out.low[k] = out.low[k].min(s);
                out.high[k] = out.high[k].max(s);
                out.radius[k] = out.radius[k].max(s.length());
            }
        }
    }
    out.widen();
    out
}

impl Enclosure {
    /// Outwards by what rounding may have taken: far more than the few operations above can lose.
    fn widen(&mut self) {
        for k in 0..3 {
            let slack = DVec3::splat(self.radius[k] * 1e-13);
            self.low[k] -= slack;
            self.high[k] += slack;
            self.radius[k] *= 1.0 + 1e-13;
        }
    }
}

/// A cone that holds all normals of a patch: the control vectors of the polynomial
/// `w P_u x P_v - w_v P_u x P - w_u P x P_v`, which is `S_u x S_v` times `w^3`.
pub fn normal_cone(net: Net) -> NormalCone {
    let normals = normal_polynomial(net);
    let unit = || normals.iter().filter_map(|n| n.try_normalize());
    let Some(axis) = unit().sum::<DVec3>().try_normalize() else {
        return NormalCone { axis: DVec3::Z, cos_angle: -1.0 };
    };
    let cos_angle = unit().map(|n| n.dot(axis)).fold(1.0, f64::min);
    NormalCone { axis, cos_angle: cos_angle - 1e-12 }
}

fn normal_polynomial(net: Net) -> Vec<DVec3> {
    let degree = net.degree();
    let component = |k: usize| Bernstein::new(degree, net.points().iter().map(move |p| p[k]));
    let p: [Bernstein<f64>; 3] = std::array::from_fn(component);
    let [pu, pv] = [0, 1].map(|axis| p.each_ref().map(|c| c.derivative(axis)));
    let cross = |a: &[Bernstein<f64>; 3], b: &[Bernstein<f64>; 3], k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i].product(&b[j]).plus(a[j].product(&b[i]), -1.0)
    };
    let normal: [Vec<f64>; 3] = if net.is_rational() {
        let w = component(3);
        let [wu, wv] = [w.derivative(0), w.derivative(1)];
        std::array::from_fn(|k| {
            let first = cross(&pu, &pv, k).product(&w);
            let second = cross(&pu, &p, k).product(&wv);
            first.plus(second, -1.0).plus(cross(&p, &pv, k).product(&wu), -1.0).coefficients()
        })
    } else {
        std::array::from_fn(|k| cross(&pu, &pv, k).coefficients())
    };
    let [x, y, z] = normal;
    x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z)).collect()
}
