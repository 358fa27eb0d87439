# Mixed model of a study: the distance at which 50 % of answers are "unnatural", and the effect of
# the centre, for faces made smaller and for faces made larger, each with its own curve.
# Raters and faces have random intercepts, raters also random slopes.
# Run in the folder of answers.csv: Rscript model.R
# Needs lme4: install.packages("lme4") or, on Debian and Ubuntu, apt install r-cran-lme4
suppressPackageStartupMessages(library(lme4))

# As text, raters 01 and 1 stay two raters.
answers <- read.csv("answers.csv", colClasses = c(study = "character", rater = "character"))
answers <- subset(answers, counts == 1 & kind == "table1" & !is.na(unnatural) & percent != 0)
answers$direction <- ifelse(answers$percent > 0, "Smaller", "Larger")
answers$size <- abs(answers$achieved_percent)

# A random term needs two raters or faces.
random <- function(rows) {
  terms <- c(rater = "(1 + distance | rater)", subject = "(1 | subject)")
  names <- c(rater = "rater", subject = "face")
  for (cluster in names(terms)) {
    if (length(unique(rows[[cluster]])) < 2) {
      cat(sprintf("A single %s: the results hold for this %s only.\n",
                  names[[cluster]], names[[cluster]]))
      terms <- terms[names(terms) != cluster]
    }
  }
  terms
}

fitted_model <- function(fixed, terms, rows) {
  formula <- as.formula(paste(c(paste("unnatural ~", fixed), terms), collapse = " + "))
  if (length(terms) == 0) return(glm(formula, data = rows, family = binomial))
  glmer(formula, data = rows, family = binomial,
        control = glmerControl(optimizer = "bobyqa", optCtrl = list(maxfun = 1e5)))
}

# Half width of the interval of a middle by the delta method. The estimated variances of few raters
# and faces are too small by (count - 1) / count; Satterthwaite's degrees of freedom allow for their
# errors.
half_width <- function(model, b, intercept, middle, terms, rows) {
  slope <- setNames(numeric(length(b)), names(b))
  slope[c(intercept, "distance")] <- c(-1, -middle) / b[["distance"]]
  variance <- as.numeric(t(slope) %*% as.matrix(vcov(model)) %*% slope)
  counts <- sapply(names(terms), function(cluster) length(unique(rows[[cluster]])))
  parts <- sapply(names(terms), function(cluster) {
    covariance <- VarCorr(model)[[cluster]]
    at <- c(1, middle)[seq_len(nrow(covariance))]
    as.numeric(t(at) %*% covariance %*% at) / b[["distance"]]^2 / (counts[[cluster]] - 1)
  })
  if (length(terms) == 0 || sum(parts) == 0) return(qnorm(0.975) * sqrt(variance))
  variance <- variance + sum(parts / counts)
  qt(0.975, variance^2 / sum(parts^2 / (counts - 1))) * sqrt(variance)
}

# Rows of a direction; none if they have no middle.
usable <- function(rows) {
  name <- rows$direction[1]
  natural <- rows$size[rows$unnatural == 0]
  unnatural <- rows$size[rows$unnatural == 1]
  if (length(natural) == 0 || length(unnatural) == 0) {
    cat(sprintf("%s: all answers are alike from %.2f to %.2f %% of D.\n",
                name, min(rows$size), max(rows$size)))
    return(NULL)
  }
  if (max(natural) < min(unnatural)) {
    cat(sprintf("%s: 50 %% unnatural between %.2f and %.2f %% of D; answers change there at once.\n",
                name, max(natural), min(unnatural)))
    return(NULL)
  }
  rows
}

report <- function(rows) {
  directions <- unique(rows$direction)
  # Centred, so that the intercepts belong to the mean distance.
  mean_size <- mean(rows$size)
  rows$distance <- rows$size - mean_size
  fixed <- if (length(directions) > 1) "0 + direction + distance" else "distance"
  terms <- random(rows)
  model <- fitted_model(fixed, terms, rows)
  print(summary(model))
  b <- if (length(terms)) fixef(model) else coef(model)
  for (direction in directions) {
    shown <- range(rows$size[rows$direction == direction])
    intercept <- if (length(directions) > 1) paste0("direction", direction) else "(Intercept)"
    middle <- -b[[intercept]] / b[["distance"]]
    error <- half_width(model, b, intercept, middle, terms, rows)
    threshold <- mean_size + middle
    outside <- threshold < shown[1] || threshold > shown[2]
    cat(sprintf("%s: 50 %% unnatural at %.2f %% of D (95 %%: %.2f to %.2f)%s\n",
                direction, threshold, threshold - error, threshold + error,
                if (outside) sprintf(", extrapolated from %.2f to %.2f %%", shown[1], shown[2])
                else ""))
  }
  rows$center <- factor(rows$center)
  if (nlevels(rows$center) > 1) {
    with_centers <- fitted_model(paste(fixed, "+ center"), terms, rows)
    print(summary(with_centers))
    cat("Do centres differ at the same achieved distance?\n")
    if (length(terms)) print(anova(model, with_centers))
    else print(anova(model, with_centers, test = "Chisq"))
  }
}

groups <- Filter(Negate(is.null), lapply(split(answers, answers$direction), usable))
distances <- sapply(groups, function(rows) length(unique(rows$percent)))
if (length(groups) > 1 && any(distances < 2)) {
  cat("A direction with a single distance has no slope of its own: one slope for both.\n")
  groups <- list(do.call(rbind, groups))
}
for (rows in groups) report(rows)
