/*
 * Shape of the shoulder on an Arduino: six string potentiometers on A0 to A5, angles on the
 * serial port. Hold the joint straight while the board starts.
 */
#include <shoulder.h>

static const int COUNTS_PER_STEP = 24;           // 50 mm of string over 1024 steps, 2 um a count
static const unsigned long PERIOD_MS = 10;

static shoulder_t joint;
static shoulder_angles_t angles;

static void readCounts(shoulder_counts_t &counts) {
  for (uint8_t j = 0; j < 3; ++j) {
    counts.u[j] = (shoulder_count_t)((analogRead(A0 + j) - 512) * COUNTS_PER_STEP);
    counts.v[j] = (shoulder_count_t)((analogRead(A3 + j) - 512) * COUNTS_PER_STEP);
  }
}

static void printDegrees(const shoulder_angle_t *steps, float radiansPerStep) {
  for (uint8_t i = 0; i < SHOULDER_SEGMENTS; ++i) {
    Serial.print(steps[i] * radiansPerStep * RAD_TO_DEG, 3);
    Serial.print(' ');
  }
}

void setup() {
  Serial.begin(115200);
  shoulder_counts_t straight;
  readCounts(straight);
  shoulder_init(&joint);
  if (shoulder_capture_zero(&joint, &straight) != CCGEN_OK) {
    Serial.println(F("a sensor is out of range"));
  }
}

void loop() {
  shoulder_counts_t counts;
  readCounts(counts);
  if (shoulder_estimate(&joint, &counts, &angles) == CCGEN_OK) {
    printDegrees(angles.u, SHOULDER_RADIANS_PER_STEP_U);
    printDegrees(angles.v, SHOULDER_RADIANS_PER_STEP_V);
    Serial.println();
  } else {
    Serial.print(F("missing sensors: "));
    Serial.println(shoulder_missing(&joint, &counts), BIN);
  }
  delay(PERIOD_MS);
}
