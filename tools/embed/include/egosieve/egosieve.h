/**
 * @file egosieve.h
 * Includes the whole C interface: models and segmenter.
 */
#ifndef EGOSIEVE_EGOSIEVE_H_
#define EGOSIEVE_EGOSIEVE_H_

#include "device_call.h"
#include "gaussian_process.h"
#include "joint_posterior.h"
#include "prediction.h"
#include "segmenter.h"

#endif /* EGOSIEVE_EGOSIEVE_H_ */
