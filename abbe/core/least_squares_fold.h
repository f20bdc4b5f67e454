// Folding rows into a triangle. Included once per instruction set, each time in a namespace of its own, by
// least_squares.cpp; with the names of that file.

/// kLanes numbers side by side: sums run in lanes, so every instruction set adds in one order.
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

[[gnu::always_inline]] inline void load(Lanes& to, const double* from) { std::memcpy(&to, from, sizeof to); }

[[gnu::always_inline]] inline double sum_of(const Lanes& lanes) {
  double sum = 0;
  for (std::size_t l = 0; l < kLanes; ++l) sum += lanes[l];
  return sum;
}

/// a . b over kRows rows.
[[gnu::always_inline]] inline double dot(const double* a, const double* b) {
  Lanes sum{};
  for (std::size_t i = 0; i < kRows; i += kLanes) {
    Lanes x, y;
    load(x, a + i), load(y, b + i);
    sum += x * y;
  }
  return sum_of(sum);
}

/// Reflections that are applied together, so that the columns behind them are read once for all.
constexpr std::size_t kPanel = 4;

/// H_k = 1 - tau v v^T, v = (1, b_k / v0), of some columns after each other. tau = 0: nothing to fold.
struct Panel {
  std::array<const double*, kPanel> b{};
  std::array<double, kPanel> v0_inverse{}, tau{};
  std::array<std::array<double, kPanel>, kPanel> between{};  ///< b_p . b_q
};

/// kLanes rows of the four columns b.
struct FourLanes {
  Lanes x0, x1, x2, x3;
};

[[gnu::always_inline]] inline void load(FourLanes& to, const Panel& panel, std::size_t i) {
  load(to.x0, panel.b[0] + i), load(to.x1, panel.b[1] + i);
  load(to.x2, panel.b[2] + i), load(to.x3, panel.b[3] + i);
}

[[gnu::always_inline]] inline void add_products(FourLanes& sums, const FourLanes& b, const double* column) {
  Lanes y;
  load(y, column);
  sums.x0 += b.x0 * y;
  sums.x1 += b.x1 * y;
  sums.x2 += b.x2 * y;
  sums.x3 += b.x3 * y;
}

using Shares = std::array<double, kPanel>;

[[gnu::always_inline]] inline void take_off(const FourLanes& b, const Shares& s, double* column) {
  Lanes y;
  load(y, column);
  y -= s[0] * b.x0;
  y -= s[1] * b.x1;
  y -= s[2] * b.x2;
  y -= s[3] * b.x3;
  std::memcpy(column, &y, sizeof y);
}

/// Reflects the rows r of one column in the triangle:
///
///     t_p = tau_p (r_p + (b_p . b_j - sum_(q < p) s_q b_p . b_q) / v0_p),   r_p -= t_p,   s_p = t_p / v0_p
[[gnu::always_inline]] inline Shares reflect_triangle(const Panel& panel, const FourLanes& products,
                                                      double* r) {
  Shares s = {sum_of(products.x0), sum_of(products.x1), sum_of(products.x2), sum_of(products.x3)};
  for (std::size_t p = 0; p < kPanel; ++p) {
    for (std::size_t q = 0; q < p; ++q) s[p] -= s[q] * panel.between[p][q];
    const double t = panel.tau[p] * (r[p] + s[p] * panel.v0_inverse[p]);
    r[p] -= t;
    s[p] = t * panel.v0_inverse[p];
  }
  return s;
}

/// The four reflections on two columns at a time, which share what is read of the panel: b_j -= sum_p s_p
/// b_p. `r`: their rows in the triangle; the same column twice is reflected once.
[[gnu::always_inline]] inline void reflect(const Panel& panel, double* r1, double* b1, double* r2,
                                           double* b2) {
  FourLanes sums1{}, sums2{}, b;
  for (std::size_t i = 0; i < kRows; i += kLanes) {
    load(b, panel, i);
    add_products(sums1, b, b1 + i);
    add_products(sums2, b, b2 + i);
  }
  const Shares s1 = reflect_triangle(panel, sums1, r1);
  const Shares s2 = b2 == b1 ? Shares{} : reflect_triangle(panel, sums2, r2);
  for (std::size_t i = 0; i < kRows; i += kLanes) {
    load(b, panel, i);
    take_off(b, s1, b1 + i);
    take_off(b, s2, b2 + i);
  }
}

/// One reflection p of a panel on one column.
[[gnu::always_inline]] inline void reflect_one(const Panel& panel, std::size_t p, double& r, double* bj) {
  const double t = panel.tau[p] * (r + dot(panel.b[p], bj) * panel.v0_inverse[p]);
  const double s = t * panel.v0_inverse[p];
  r -= t;
  for (std::size_t i = 0; i < kRows; ++i) bj[i] -= s * panel.b[p][i];
}

/// Householder: folds kRows rows (columns one after the other) into the triangle r, both m1 columns. Under
/// the diagonal the triangle is zero, so each reflection touches one row of it:
///
///     v0 = alpha - beta,  beta = -sign(alpha) |(alpha, b_k)|,  tau = -v0 / beta
///
/// r is stored by columns with m1 rows.
inline void fold_block(double* r, double* block, std::size_t m1) {
  for (std::size_t first = 0; first < m1; first += kPanel) {
    const std::size_t count = std::min(kPanel, m1 - first);
    Panel panel;
    for (std::size_t p = 0; p < count; ++p) {
      const std::size_t k = first + p;
      const double* const bk = panel.b[p] = block + k * kRows;
      if (const double square = dot(bk, bk); square != 0) {
        double& alpha = r[k * m1 + k];
        const double beta = std::sqrt(alpha * alpha + square) * (alpha > 0 ? -1 : 1), v0 = alpha - beta;
        panel.v0_inverse[p] = 1 / v0;
        panel.tau[p] = -v0 / beta;
        alpha = beta;
      }
      for (std::size_t q = 0; q < p; ++q) panel.between[p][q] = dot(bk, panel.b[q]);
      for (std::size_t j = k + 1; j < first + count; ++j)
        reflect_one(panel, p, r[j * m1 + k], block + j * kRows);
    }
    for (std::size_t j = first + kPanel; j < m1; j += 2) {
      const std::size_t l = std::min(j + 1, m1 - 1);
      reflect(panel, r + j * m1 + first, block + j * kRows, r + l * m1 + first, block + l * kRows);
    }
  }
}
