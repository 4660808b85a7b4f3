// SPDX-License-Identifier: Apache-2.0
#include "calib/pair_terms.h"

#include <algorithm>
#include <cmath>

namespace geond::calib {
namespace {

constexpr float kCrease = 2.5f;  // times the median residual of a view's normals
constexpr double kTukey = 4.0;  // distances beyond so many scales have no weight

struct Meeting {
  Eigen::Vector3d p_T, q_T, normal_T;
  Eigen::Vector3d half_turn_T;  // half the difference of the two normals
  double distance;              // along the mean normal, from q to p
  bool at_crease;
};

// Where the points of one view meet the surface seen by another.
class Meetings {
 public:
  Meetings(const ViewPoints& a, const ViewPoints& b, const Pose& X_TA, const Pose& X_TB, const PairOptions& options)
      : a_(a), b_(*b.view), target_(b.target), crease_(b.crease), options_(options), R_TA_(X_TA.matrix()), R_TB_(X_TB.matrix()),
        t_TA_(X_TA.translation()), t_TB_(X_TB.translation()) {
    const Pose X_BA = Inverse(X_TB) * X_TA;
    R_BA_ = X_BA.matrix();
    t_BA_ = X_BA.translation();
  }

  bool Find(std::size_t i, Meeting& meeting) const {
    const Eigen::Vector3d p_B = R_BA_ * a_.points_S[i] + t_BA_;
    const auto pixel = Project(b_.sensor, p_B);
    if (!pixel) return false;
    const double u = std::floor((*pixel)[0] + 0.5), v = std::floor((*pixel)[1] + 0.5);
    if (!(u >= 0 && v >= 0 && u < b_.image.columns && v < b_.image.rows)) return false;
    const std::size_t index = b_.image.index(static_cast<int>(u), static_cast<int>(v));
    if (!target_[index]) return false;
    const Eigen::Vector3d q_B = Unproject(b_.sensor, u, v, b_.image.depth[index]);
    if ((p_B - q_B).squaredNorm() > options_.max_distance * options_.max_distance) return false;
    const Eigen::Vector3d n_b = b_.normals_S[index].cast<double>();
    const Eigen::Vector3d n_a = R_BA_ * a_.normals_S[i];
    const double cosine = n_a.dot(n_b);
    if (cosine < options_.min_cosine) return false;
    meeting.normal_T = R_TB_ * (n_a + n_b).normalized();
    meeting.p_T = R_TA_ * a_.points_S[i] + t_TA_;
    meeting.q_T = R_TB_ * q_B + t_TB_;
    meeting.distance = meeting.normal_T.dot(meeting.p_T - meeting.q_T);
    meeting.half_turn_T = R_TB_ * (0.5 * (n_a - n_b));
    meeting.at_crease = a_.residuals[i] > a_.crease ||
                        (!b_.normal_residuals.empty() && b_.normal_residuals[index] > crease_);
    return true;
  }

 private:
  const ViewPoints& a_;
  const RangeView& b_;
  const std::vector<std::uint8_t>& target_;
  const float crease_;
  const PairOptions& options_;
  Eigen::Matrix3d R_TA_, R_TB_, R_BA_;
  Eigen::Vector3d t_TA_, t_TB_, t_BA_;
};

double TukeyWeight(double r, double scale) {
  const double x = r / (kTukey * scale);
  return std::abs(x) < 1.0 ? (1.0 - x * x) * (1.0 - x * x) : 0.0;
}

// Of a residual with this weight, in halves of the squared scale: near r^2 for small ones, constant for outliers.
double TukeyLoss(double weight) { return kTukey * kTukey / 3.0 * (1.0 - weight * std::sqrt(weight)); }

}  // namespace

double Median(std::vector<float>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

ViewPoints ReadyForRegistration(const RangeView& view) {
  ViewPoints ready;
  ready.view = &view;
  ready.target.assign(view.classes.size(), 0);
  const auto usable = [&](int column, int row) {
    if (!view.image.contains(column, row)) return false;
    const std::size_t i = view.image.index(column, row);
    return view.IsObject(i) && view.normals_S[i].allFinite();
  };
  for (int row = 0; row < view.image.rows; ++row) {
    for (int column = 0; column < view.image.columns; ++column) {
      if (!usable(column, row)) continue;
      const std::size_t i = view.image.index(column, row);
      ready.points_S.push_back(Unproject(view.sensor, column, row, view.image.depth[i]));
      ready.normals_S.push_back(view.normals_S[i].cast<double>());
      ready.residuals.push_back(view.normal_residuals.empty() ? 0.0f : view.normal_residuals[i]);
      ready.target[i] = usable(column - 1, row) && usable(column + 1, row) && usable(column, row - 1) &&
                        usable(column, row + 1);
    }
  }
  std::vector<float> residuals = ready.residuals;
  ready.crease = kCrease * static_cast<float>(Median(residuals));
  return ready;
}

PairTerm ComparePair(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS, int a, int b,
                     const Eigen::Vector3d& center_T, double length, const PairOptions& options) {
  PairTerm term;
  term.a = a;
  term.b = b;
  const ViewPoints& from = views[a];
  const std::size_t n = from.points_S.size();
  const std::size_t take = std::min<std::size_t>(n, std::max(1, options.samples));
  const std::size_t first = n == 0 ? 0 : (static_cast<std::size_t>(b) * 7919) % n;  // others of the points with each view
  const Meetings meetings(from, views[b], X_TS[a], X_TS[b], options);

  // Rows (m x n, n, r) by blocks: the products of a whole block at once are what the processor does well.
  constexpr int kBlock = 64;
  Eigen::Matrix<double, 7, kBlock> block;
  int filled = 0;
  Eigen::Matrix<double, 7, 7> sums = Eigen::Matrix<double, 7, 7>::Zero();
  const auto flush = [&] {
    block.rightCols(kBlock - filled).setZero();
    sums.noalias() += block * block.transpose();
    filled = 0;
  };
  // An error e of the normal makes j wrong by (m x e, e). Half the difference of the two normals is such an error of their
  // mean, as far as they are independent.
  Matrix6d noise = Matrix6d::Zero();
  Meeting meeting;
  for (std::size_t k = 0; k < take; ++k) {
    const std::size_t i = (k * n + first) / take;
    if (!meetings.Find(i, meeting)) continue;
    ++term.points;
    term.distances.push_back(static_cast<float>(std::abs(meeting.distance)));
    term.squares += meeting.distance * meeting.distance;
    const double w = TukeyWeight(meeting.distance, options.scale);
    term.loss += TukeyLoss(w);
    if (w <= 0.0) continue;
    term.weight += w;
    const double root = std::sqrt(w);
    const Eigen::Vector3d arm = (0.5 * (meeting.p_T + meeting.q_T) - center_T) / length;
    block.col(filled) << root * arm.cross(meeting.normal_T), root * meeting.normal_T, root * meeting.distance;
    Vector6d off;
    off << arm.cross(meeting.half_turn_T), meeting.half_turn_T;
    noise.noalias() += w * off * off.transpose();
    if (meeting.at_crease) {
      const Vector6d row = block.col(filled).head<6>();
      term.H_creases.noalias() += row * row.transpose();
      term.noise_creases.noalias() += w * off * off.transpose();
    }
    if (++filled == kBlock) flush();
  }
  flush();
  const double information = 1.0 / (options.scale * options.scale);
  term.H = information * sums.topLeftCorner<6, 6>();
  term.g = information * sums.col(6).head<6>();
  term.noise = information * noise;
  term.H_creases *= information;
  term.noise_creases *= information;
  return term;
}

}  // namespace geond::calib
