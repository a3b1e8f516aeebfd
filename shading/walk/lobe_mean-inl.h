// The mean of a specular lobe over directions: one formula for float, double and SIMD vectors. Included into
// each namespace that defines `larger`, `smaller`, `square_root` and `power` for its numbers.

/// Returns the mean of cos^exponent of a lobe's angle over directions around a middle direction.
///
/// at      the middle direction w: `mirror` is its cosine with R, `across` its component across the plane of
///         incidence; `eye_square` is the squared length of V + w, `eye_normal` the component along N.
///         `spread` is the variance of the directions, 0 for a single one. `all(x)` is x as a Number.
/// source  the mean of a lobe cos^n over directions with variance s is about cos^m of their middle, with
///         1/m = 1/n + s and the same energy: the variances of narrow functions add under convolution. For
///         the lobe about H the approximation is made in H. There the variance is s / 4 in the plane of
///         incidence, and s / (2 V.H)^2 across it.
template <class Number, class Middle, class Real>
[[gnu::always_inline]] inline Number lobe_mean(const BasicLobe<Real>& lobe, const Middle& at) {
    if (lobe.exponent == 0) return at.all(1);
    const Number n = at.all(lobe.exponent), one = at.all(1);
    const Number energy = at.all(1 / (lobe.exponent + 1));
    if (lobe.axis == LobeAxis::mirror) {
        const Number m = n / (one + n * at.spread());
        return (m + one) * energy * power(at.mirror(), m);
    }
    // |V + w| = 2 V.H; from it follow N.H and the component of H across the plane of incidence.
    const Number square = larger(at.eye_square(), at.all(Real(1e-4)));
    const Number inverse = one / square_root(square);
    const Number height = at.eye_normal() * inverse;
    const Number across = at.across() * inverse;
    const Number share_across =
        smaller(across * across / larger(one - height * height, at.all(Real(1e-6))), one);
    const Number m = n / (one + n * at.spread() * at.all(Real(0.25))),
                 m_across = n / (one + n * at.spread() / square);
    return square_root((m + one) * (m_across + one)) * energy *
           power(height, m + (m_across - m) * share_across);
}
