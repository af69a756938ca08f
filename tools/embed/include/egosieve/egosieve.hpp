/**
 * @file egosieve.hpp
 * Includes the whole C++17 interface: models and segmenter. Views of Eigen's matrices are in
 * eigen.hpp.
 */
#ifndef EGOSIEVE_EGOSIEVE_HPP_
#define EGOSIEVE_EGOSIEVE_HPP_

#include "gaussian_process.hpp"
#include "segmenter.hpp"

#endif  // EGOSIEVE_EGOSIEVE_HPP_
